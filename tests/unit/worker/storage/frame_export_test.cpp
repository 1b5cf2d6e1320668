// Frames for viewers: every number of the stored frames is there, under the names that viewers
// know.
#include "worker/storage/frame_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "tests/support/sample_result.h"
#include "tests/support/temporary_directory.h"
#include "worker/storage/result_reader.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

using namespace granary::testing;
using ::testing::HasSubstr;

class FrameExport : public ::testing::Test {
 protected:
  FrameExport() { write_sample_result(directory / "r.h5"); }
  static std::string text_of(const Path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // The rows x 3 (or rows x 1) that a viewer must see of a column.
  static std::vector<double> shown(const NumberColumn& column) {
    std::vector<double> numbers;
    for (std::size_t i = 0; i < column.values.size(); ++i) {
      numbers.push_back(column.values[i]);
      if (column.width == 2 && i % 2 == 1) numbers.push_back(0);
    }
    return numbers;
  }
  // The numbers of one array of a .vtp file.
  template <typename Number>
  static std::vector<Number> array(const std::string& vtp, const std::string& name) {
    const auto start = vtp.find('>', vtp.find("Name=\"" + name + "\"")) + 1;
    const std::string text = vtp.substr(start, vtp.find('<', start) - start);
    std::vector<unsigned char> bytes(text.size());
    EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(text.data()),
                    static_cast<int>(text.size()));
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data(), sizeof size);
    std::vector<Number> numbers(size / sizeof(Number));
    std::memcpy(numbers.data(), bytes.data() + sizeof size, size);
    return numbers;
  }

  TemporaryDirectory directory;
};

TEST_F(FrameExport, xyz_has_a_block_per_frame_with_named_columns) {
  const auto files = export_xyz(directory / "r.h5", directory / "out");
  ASSERT_EQ(files.size(), 1u);
  const ResultReader reader(directory / "r.h5");
  std::ifstream file(files[0]);
  for (std::size_t index = 0; index < reader.frame_count(); ++index) {
    const StoredFrame frame = reader.frame(index);
    const NumberColumn& position = *frame.grains.find("position_m");
    const std::size_t rows = position.values.size() / position.width;
    std::string line;
    ASSERT_TRUE(std::getline(file, line));
    EXPECT_EQ(line, std::to_string(rows));
    std::getline(file, line);
    EXPECT_THAT(line, HasSubstr("Properties=pos:R:3:"));
    std::ostringstream time;
    time << "Time=" << frame.time_s << " ";
    EXPECT_THAT(line, HasSubstr(time.str()));
    const std::vector<double> expected = shown(position);
    for (std::size_t row = 0; row < rows; ++row) {
      std::getline(file, line);
      std::istringstream numbers(line);
      for (std::size_t k = 0; k < 3; ++k) {
        double value = 0;
        numbers >> value;
        EXPECT_FLOAT_EQ(static_cast<float>(value), static_cast<float>(expected[3 * row + k]));
      }
    }
  }
  std::string rest;
  EXPECT_FALSE(std::getline(file, rest)) << rest;
}

TEST_F(FrameExport, paraview_gets_every_column_of_every_frame) {
  const auto files = export_paraview(directory / "r.h5", directory / "out");
  const ResultReader reader(directory / "r.h5");
  ASSERT_EQ(files.size(), 1 + reader.frame_count());
  const std::string collection = text_of(files[0]);
  for (std::size_t index = 0; index < reader.frame_count(); ++index) {
    const StoredFrame frame = reader.frame(index);
    EXPECT_THAT(collection, HasSubstr("file=\"frames/" + frame.grains.name + ".vtp\""));
    const std::string vtp = text_of(files[1 + index]);
    for (const NumberColumn& column : frame.grains.columns) {
      const std::vector<float> numbers = array<float>(vtp, column.name);
      const std::vector<double> expected = shown(column);
      ASSERT_EQ(numbers.size(), expected.size()) << column.name;
      for (std::size_t i = 0; i < numbers.size(); ++i)
        EXPECT_EQ(numbers[i], static_cast<float>(expected[i])) << column.name;
    }
    const auto offsets = array<std::int32_t>(vtp, "offsets");
    for (std::size_t i = 0; i < offsets.size(); ++i)
      EXPECT_EQ(offsets[i], static_cast<std::int32_t>(i + 1));
  }
}

TEST_F(FrameExport, what_is_no_result_file_is_an_error) {
  std::ofstream(directory / "no.h5") << "not HDF5";
  EXPECT_THROW(export_xyz(directory / "no.h5", directory / "out"), StorageError);
  EXPECT_THROW(export_paraview(directory / "no.h5", directory / "out"), StorageError);
}

}  // namespace
}  // namespace granary::storage
