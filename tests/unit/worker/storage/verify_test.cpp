#include "worker/storage/verify.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>

#include <filesystem>
#include <fstream>

#include "tests/support/sample_result.h"
#include "tests/support/temporary_directory.h"

namespace granary::storage {
namespace {

using namespace granary::testing;

class VerifyResult : public ::testing::Test {
 protected:
  void SetUp() override { write_sample_result(path); }

  bool complains_about(const std::string& what) const {
    for (const std::string& problem : verify_result(path).problems)
      if (problem.find(what) != std::string::npos) return true;
    return false;
  }

  // As any other program would change the file.
  template <typename Change>
  void change(Change&& how) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    how(file);
    H5Fclose(file);
  }

  void overwrite(const char* dataset_path, double value) {
    change([&](hid_t file) {
      const hid_t dataset = H5Dopen2(file, dataset_path, H5P_DEFAULT);
      H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value);
      H5Dclose(dataset);
    });
  }

  TemporaryDirectory directory;
  std::filesystem::path path = directory / "r.h5";
};

TEST_F(VerifyResult, accepts_a_whole_file) {
  const VerifyReport report = verify_result(path);
  EXPECT_TRUE(report.ok()) << report.problems.front();
  EXPECT_EQ(report.frame_count, 3u);
  EXPECT_GT(report.dataset_count, 30u);
}

TEST_F(VerifyResult, finds_a_changed_value) {
  overwrite("/values/f1_m", 2.92);
  EXPECT_TRUE(complains_about("/values/f1_m: checksum is wrong"));
}

TEST_F(VerifyResult, finds_a_value_that_is_no_number) {
  overwrite("/values/f1_m", std::nan(""));
  EXPECT_TRUE(complains_about("/values/f1_m: holds NaN or infinity"));
}

TEST_F(VerifyResult, finds_missing_units) {
  change([](hid_t file) { H5Adelete_by_name(file, "/ledger/kinetic", "units", H5P_DEFAULT); });
  EXPECT_TRUE(complains_about("/ledger/kinetic: has no units"));
}

TEST_F(VerifyResult, finds_a_missing_and_a_strange_dataset) {
  change([](hid_t file) {
    H5Lmove(file, "/ledger/kinetic", file, "/ledger/other", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_TRUE(complains_about("/ledger/kinetic: is missing"));
  EXPECT_TRUE(complains_about("/ledger/other: is not in the list"));
}

TEST_F(VerifyResult, finds_a_file_cut_at_any_length) {
  const auto size = std::filesystem::file_size(path);
  for (auto length = size; length > 0;) {
    length = length > 997 ? length - 997 : 0;
    std::filesystem::resize_file(path, length);
    EXPECT_FALSE(verify_result(path).ok()) << "cut at " << length << " of " << size;
  }
}

TEST_F(VerifyResult, finds_any_changed_byte_of_a_datasets_bytes) {
  // The bytes of a column are found by a value that occurs nowhere else.
  const std::vector<double> column(64, 1.2345678901234567);
  {
    ResultWriter writer(real_file_system(), path);
    writer.add_frame({0, 0, "", {core::make_column<double>("x_m", "m", column)}});
    writer.add_content(sample_content());
    writer.commit();
  }
  std::ifstream in(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const std::string needle(reinterpret_cast<const char*>(column.data()), 8 * column.size());
  const std::size_t at = bytes.find(needle);
  ASSERT_NE(at, std::string::npos);
  for (std::size_t i = at; i < at + needle.size(); i += 7) {
    bytes[i] = static_cast<char>(bytes[i] ^ 1);
    std::ofstream(path, std::ios::binary) << bytes;
    EXPECT_TRUE(complains_about("/frames/000000/x_m: checksum is wrong")) << "byte " << i;
    bytes[i] = static_cast<char>(bytes[i] ^ 1);
  }
}

TEST_F(VerifyResult, says_what_is_no_result_file) {
  std::ofstream(path) << "not HDF5 at all";
  EXPECT_TRUE(complains_about("cannot open"));
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(file);
  EXPECT_FALSE(verify_result(path).ok());
  EXPECT_FALSE(verify_result(directory / "absent.h5").ok());
}

}  // namespace
}  // namespace granary::storage
