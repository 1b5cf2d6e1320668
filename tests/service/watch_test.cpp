// Two workers, ten jobs, three watchers; watchers and servers that are cut off.
#include <gmock/gmock.h>
#include <signal.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using testing::HasSubstr;

class Watch : public RealService {};

TEST_F(Watch, ten_jobs_on_two_workers_all_end_and_three_watchers_see_100_percent) {
  std::vector<std::string> jobs;
  for (int i = 1; i <= 10; ++i)
    jobs.push_back(submit({scene("discharge_small"), "--set", "seed=" + std::to_string(i)}).at(0));
  std::vector<std::unique_ptr<Program>> watchers;
  for (const int i : {0, 4, 9})
    watchers.push_back(start_granary({"watch", jobs[static_cast<std::size_t>(i)]}));
  auto cut_off = start_granary({"watch", jobs[9]});
  ASSERT_TRUE(cut_off->prints("waiting"));
  cut_off->signal(SIGKILL);
  cut_off->wait();
  start_worker();
  start_worker();
  auto restarted = start_granary({"watch", jobs[9]});
  for (auto& watcher : watchers) {
    EXPECT_EQ(watcher->wait(std::chrono::seconds(60)), 0) << watcher->err();
    watcher->collect_output();
    EXPECT_THAT(watcher->err(), HasSubstr("100 %"));
  }
  EXPECT_EQ(restarted->wait(std::chrono::seconds(60)), 0);
  restarted->collect_output();
  EXPECT_THAT(restarted->err(), HasSubstr("100 %"));
  for (const std::string& job : jobs) EXPECT_TRUE(reaches(job, "complete")) << job;
  std::set<std::string> used;
  for (const std::string& job : jobs) used.insert(status(job)["worker"].get<std::string>());
  EXPECT_EQ(used.size(), 2u);
}

TEST_F(Watch, goes_on_when_the_server_is_killed_and_started_again) {
  start_worker();
  std::vector<std::string> arguments = long_scene();
  arguments[2] = "discharge.time_step_s=1e-5";
  arguments[4] = "discharge.filling_time_step_s=1e-5";
  const std::string job = submit(arguments).at(0);
  auto watcher = start_granary({"watch", job});
  ASSERT_TRUE(watcher->prints("running"));
  kill_server();
  start_server();
  EXPECT_EQ(watcher->wait(std::chrono::seconds(90)), 0) << watcher->err();
  watcher->collect_output();
  EXPECT_THAT(watcher->err(), HasSubstr("100 %"));
  EXPECT_EQ(state(job), "complete");
  EXPECT_EQ(status(job)["attempts"], 1) << "the worker kept its task over the restart";
}

}  // namespace
}  // namespace granary::test
