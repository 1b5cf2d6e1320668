// kill -9 of a worker or an engine in mid-job: the job ends once, by somebody else if need be.
#include <signal.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

class LostProcess : public RealService {
 protected:
  // About two seconds of computing.
  std::vector<std::string> medium_scene() const {
    return {scene("discharge_small"), "--set", "discharge.time_step_s=1e-5", "--set",
            "discharge.filling_time_step_s=1e-5"};
  }
};

TEST_F(LostProcess, a_killed_worker_s_job_is_completed_by_the_other_and_stored_once) {
  Program& doomed = start_worker();
  const std::string job = submit(medium_scene()).at(0);
  std::vector<pid_t> engines;
  ASSERT_TRUE(
      eventually([&] { return !(engines = children_with(doomed.pid(), "--engine")).empty(); }));
  start_worker();
  doomed.signal(SIGKILL);
  doomed.wait();
  EXPECT_TRUE(eventually([&] { return !is_alive(engines[0]); }))
      << "the engine outlived its worker";
  ASSERT_TRUE(reaches(job, "complete"));
  const auto record = status(job);
  EXPECT_EQ(record["attempts"], 2);
  EXPECT_NE(record["worker"].get<std::string>().find(std::to_string(workers[1]->pid())),
            std::string::npos);
  // The interrupted run and an undisturbed one agree to the last bit.
  const Outputs disturbed = granary({"values", job, "--format", "json"});
  std::vector<std::string> fresh = medium_scene();
  fresh.insert(fresh.begin(), {"run", "--fresh", "--format", "json"});
  const Outputs undisturbed = granary(fresh);
  EXPECT_EQ(nlohmann::json::parse(disturbed.out)["state_hash"],
            nlohmann::json::parse(undisturbed.out)["state_hash"]);
}

TEST_F(LostProcess, a_killed_engine_is_started_again_and_a_crash_loop_ends) {
  Program& worker = start_worker();
  const std::string job = submit(long_scene()).at(0);
  std::set<pid_t> killed;
  for (int i = 0; i < 3; ++i) {  // the budget for unknown causes is two retries
    std::vector<pid_t> engines;
    ASSERT_TRUE(eventually([&] {
      engines = children_with(worker.pid(), "--engine");
      return !engines.empty() && !killed.count(engines[0]);
    })) << "after "
        << i << " kills";
    killed.insert(engines[0]);
    ::kill(engines[0], SIGKILL);
  }
  ASSERT_TRUE(reaches(job, "error"));
  EXPECT_NE(status(job)["error"].get<std::string>().find("signal 9"), std::string::npos);
  EXPECT_EQ(granary({"values", job}).exit_code, 1);
  EXPECT_EQ(granary({"run", scene("discharge_small"), "-q"}).exit_code, 0) << "others go on";
}

// A frozen worker is what a half-open connection looks like: the stream stays, the lease ends. Thawed, it
// still believes in its task.
TEST_F(LostProcess, a_frozen_worker_loses_its_task_and_its_late_result_is_refused) {
  Program& zombie = start_worker();
  const std::string job = submit(medium_scene()).at(0);
  ASSERT_TRUE(eventually([&] { return !children_with(zombie.pid(), "--engine").empty(); }));
  zombie.signal(SIGSTOP);  // its engine computes on
  start_worker();
  ASSERT_TRUE(reaches(job, "complete"));
  const auto before = status(job);
  EXPECT_EQ(before["attempts"], 2);
  zombie.signal(SIGCONT);
  ASSERT_TRUE(zombie.prints("event=disconnected")) << zombie.err();
  ASSERT_TRUE(eventually([&] { return children_with(zombie.pid(), "--engine").empty(); }));
  const std::string other = submit({scene("discharge_small"), "--fresh"}).at(0);
  ASSERT_TRUE(reaches(other, "complete")) << "it works on";
  EXPECT_EQ(status(job), before) << "nothing of the zombie was stored";
}

TEST_F(LostProcess, a_drained_worker_hands_its_job_back) {
  Program& leaving = start_worker();
  const std::string job = submit(medium_scene()).at(0);
  ASSERT_TRUE(eventually([&] { return !children_with(leaving.pid(), "--engine").empty(); }));
  start_worker();
  leaving.signal(SIGTERM);
  EXPECT_EQ(leaving.wait(), 0);
  EXPECT_TRUE(reaches(job, "complete"));
}

}  // namespace
}  // namespace granary::test
