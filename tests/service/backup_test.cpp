// granary backup: a copy of the live database that a server starts from.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;

class Backup : public RealService {};

TEST_F(Backup, of_a_busy_server_restores_every_job_of_its_moment) {
  start_worker();
  const std::string done = submit({scene("discharge_small")}).at(0);
  ASSERT_TRUE(reaches(done, "complete"));
  const std::string running = submit(long_scene()).at(0);
  ASSERT_TRUE(reaches(running, "running"));
  const std::string waiting = submit({scene("discharge_700_gravity")}).at(0);
  const std::string file = scratch.file("backup.db");
  const Outputs made = granary({"backup", file, "--format", "json"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(json::parse(made.out)["size_bytes"], std::filesystem::file_size(file));
  EXPECT_FALSE(std::filesystem::exists(file + ".part"));

  submit({scene("discharge_700_centrifugal")});  // after the backup
  kill_server();
  workers.clear();
  std::filesystem::remove_all(scratch.file("data"));
  std::filesystem::create_directories(scratch.file("data"));
  std::filesystem::copy(file, scratch.file("data/granary.db"));
  start_server();
  EXPECT_EQ(json::parse(granary({"ls", "--format", "json"}).out).size(), 3u);
  EXPECT_EQ(state(done), "complete");
  EXPECT_EQ(state(waiting), "waiting");
  EXPECT_EQ(granary({"values", done}).exit_code, 0);
  const Outputs gone = granary({"fetch", done, "-o", scratch.file("gone.h5")});
  EXPECT_NE(gone.exit_code, 0) << "its file was not restored";
  EXPECT_THAT(gone.err, testing::HasSubstr("gone"));
}

TEST_F(Backup, keeps_what_is_there_unless_forced) {
  const std::string file = scratch.write("there.db", "precious");
  const Outputs refused = granary({"backup", file});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_EQ(file_text(file), "precious");
  EXPECT_EQ(granary({"backup", file, "--force"}).exit_code, 0);
  EXPECT_NE(file_text(file), "precious");
}

}  // namespace
}  // namespace granary::test
