// Cancel reaches a running engine: its process is gone within a second.
#include <signal.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

class Cancel : public RealService {};

TEST_F(Cancel, stops_a_running_engine_within_one_second) {
  Program& worker = start_worker();
  const std::string job = submit(long_scene()).at(0);
  std::vector<pid_t> engines;
  ASSERT_TRUE(
      eventually([&] { return !(engines = children_with(worker.pid(), "--engine")).empty(); }));
  ASSERT_TRUE(reaches(job, "running"));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(granary({"cancel", job}).exit_code, 0);
  EXPECT_TRUE(eventually([&] { return !is_alive(engines[0]); }));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  EXPECT_TRUE(reaches(job, "cancelled"));
  EXPECT_EQ(granary({"watch", job}).exit_code, 7);
  // The slot is free again.
  EXPECT_EQ(granary({"run", scene("discharge_small"), "-q"}).exit_code, 0);
}

TEST_F(Cancel, a_stopped_engine_that_ignores_everything_is_killed) {
  Program& worker = start_worker();
  const std::string job = submit(long_scene()).at(0);
  std::vector<pid_t> engines;
  ASSERT_TRUE(
      eventually([&] { return !(engines = children_with(worker.pid(), "--engine")).empty(); }));
  ::kill(engines[0], SIGSTOP);  // hangs: no polite signal is answered
  EXPECT_EQ(granary({"cancel", job}).exit_code, 0);
  EXPECT_TRUE(reaches(job, "cancelled"));
  EXPECT_FALSE(is_alive(engines[0]));
}

TEST_F(Cancel, a_time_limit_ends_the_job_with_exit_8) {
  start_worker();
  std::vector<std::string> arguments = long_scene();
  arguments.insert(arguments.begin(), {"submit", "--time-limit", "1", "--wait"});
  EXPECT_EQ(granary(arguments).exit_code, 8);
}

}  // namespace
}  // namespace granary::test
