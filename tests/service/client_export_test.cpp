// export --to csv: the tables of a real result file, by the names and columns of the contract.
#include <filesystem>
#include <sstream>

#include "proto/contract/sha256.h"
#include "tests/support/client_fixture.h"
#include "tests/support/result_reader.h"

namespace granary::test {
namespace {

using ::testing::HasSubstr;

class ClientExport : public ClientTest {
 protected:
  void SetUp() override {
    const std::string file = scratch_.file("made.h5");
    const Outputs made = run_program(
        {.command = {GRANARY_BIN "/granary-worker", "--scene",
                     std::string(GRANARY_SCENES) + "/discharge_small.txtpb", "-q", "-o", file},
         .environment = {{"HOME", scratch_.path()}},
         .input = ""});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    FakeJob& fake = jobs().add("jobs/1");
    fake.file = file_text(file);
    fake.job.mutable_result()->set_sha256(sha256_hex(fake.file));
    fake.job.mutable_result()->set_size_bytes(fake.file.size());
    stored_ = testing::read_result(file);
  }

  struct Csv {
    std::string header;
    std::vector<std::vector<double>> rows;
  };
  Csv read(const std::string& name) {
    std::istringstream text(file_text(scratch_.file("out/" + name)));
    Csv csv;
    std::getline(text, csv.header);
    for (std::string line; std::getline(text, line);) {
      std::istringstream cells(line);
      auto& row = csv.rows.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    }
    return csv;
  }
  std::vector<double> stored(const std::string& path) {
    return stored_.datasets.at(path).as<double>();
  }

  testing::StoredResult stored_;
};

TEST_F(ClientExport, csv_holds_every_digit_of_the_stored_tables) {
  const Outputs outputs = granary({"export", "jobs/1", "--to", "csv", "-o", scratch_.file("out")});
  ASSERT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_THAT(outputs.out, HasSubstr(scratch_.file("out/remaining.csv") + "\n"));

  const Csv remaining = read("remaining.csv");
  EXPECT_EQ(remaining.header, "angle_deg,remaining_percent");
  const auto percent = stored("/series/remaining/remaining_percent");
  ASSERT_EQ(remaining.rows.size(), percent.size());
  ASSERT_EQ(percent.size(), 181u);  // every degree of half a turn
  for (std::size_t i = 0; i < percent.size(); ++i) {
    EXPECT_EQ(remaining.rows[i][0], static_cast<double>(i));
    EXPECT_EQ(remaining.rows[i][1], percent[i]);
  }

  const Csv cg = read("cg.csv");
  EXPECT_EQ(cg.header, "time_s,angle_deg,x_m,y_m");
  const auto x = stored("/series/cg/x_m");
  ASSERT_EQ(cg.rows.size(), static_cast<std::size_t>(std::count_if(
                                x.begin(), x.end(), [](double v) { return std::isfinite(v); })));
  EXPECT_EQ(cg.rows[0][2], x[0]);
}

TEST_F(ClientExport, leaves_nothing_behind_but_the_tables) {
  ASSERT_EQ(granary({"export", "1", "--to", "csv", "-o", scratch_.file("out")}).exit_code, 0);
  for (const auto& entry : std::filesystem::directory_iterator(scratch_.file("out")))
    EXPECT_EQ(entry.path().extension(), ".csv") << entry.path();
}

TEST_F(ClientExport, result_that_is_no_hdf5_file_is_exit_9) {
  FakeJob& fake = jobs().add("jobs/2");
  fake.file = "not HDF5";
  fake.job.mutable_result()->set_sha256(sha256_hex(fake.file));
  fake.job.mutable_result()->set_size_bytes(fake.file.size());
  const Outputs outputs = granary({"export", "2", "--to", "csv", "-o", scratch_.file("out")});
  EXPECT_EQ(outputs.exit_code, 9);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
}

TEST_F(ClientExport, verify_looks_inside_the_file) {
  const std::string file = scratch_.file("result.h5");
  ASSERT_EQ(granary({"fetch", "1", "-o", file}).exit_code, 0);
  const Outputs whole = granary({"verify", file, "--format", "json"});
  EXPECT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_THAT(whole.out, HasSubstr("\"datasets\":\"intact\""));
  EXPECT_EQ(granary({"verify", file, "--sha256", std::string(64, '0')}).exit_code, 9);
  // One bit of one dataset; the recorded sum is gone too, so only the inside can tell.
  std::string content = file_text(file);
  const auto bytes = stored_.datasets.at("/series/remaining/remaining_percent").bytes;
  const std::string needle(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto at = content.find(needle);
  ASSERT_NE(at, std::string::npos);
  content[at + 3] ^= 1;
  scratch_.write("result.h5", content);
  std::filesystem::remove(file + ".sha256");
  EXPECT_EQ(granary({"verify", file}).exit_code, 9);
}

}  // namespace
}  // namespace granary::test
