// The queue with many jobs, workers and watchers, some of them stuck: nothing is lost, nothing is given
// out twice, and everybody else is served. Sizes reduced; tests/bench/queue_scale measures the full ones.
#include <set>

#include "tests/support/queue_client.h"
#include "tests/support/real_service.h"
#include "tests/support/simulated_worker.h"

namespace granary::test {
namespace {

class ManyJobs : public RealService {
 protected:
  std::vector<std::unique_ptr<SimulatedWorker>> start_simulated(int count) const {
    std::vector<std::unique_ptr<SimulatedWorker>> started;
    for (int i = 0; i < count; ++i)
      started.push_back(std::make_unique<SimulatedWorker>(address, "simulated-" + std::to_string(i), 1));
    return started;
  }
};

TEST_F(ManyJobs, each_is_given_to_one_worker_once) {
  constexpr std::uint64_t kJobs = 2000;
  QueueClient client(address);
  client.submit(0, kJobs);
  auto simulated = start_simulated(20);
  const auto done = [&] {
    std::uint64_t sum = 0;
    for (const auto& worker : simulated) sum += worker->tasks_done();
    return sum;
  };
  ASSERT_TRUE(eventually([&] { return done() >= kJobs; }, std::chrono::seconds(120))) << done();
  std::set<std::string> jobs;
  std::size_t assigned = 0;
  for (const auto& worker : simulated) {
    worker->stop();
    const auto own = worker->jobs();
    jobs.insert(own.begin(), own.end());
    assigned += own.size();
  }
  EXPECT_EQ(assigned, kJobs);
  EXPECT_EQ(jobs.size(), kJobs);
  EXPECT_EQ(client.count_all(300), kJobs) << "pages neither skip nor repeat";
}

TEST_F(ManyJobs, submissions_are_answered_under_fifty_watchers_ten_of_them_stuck) {
  QueueClient client(address);
  const std::string watched = client.submit(0, 1).at(0);
  std::vector<std::unique_ptr<QueueWatcher>> watchers;
  for (int i = 0; i < 50; ++i) watchers.push_back(std::make_unique<QueueWatcher>(address, watched, i % 5 == 0));
  for (std::uint64_t i = 1; i <= 200; ++i) client.submit(i, 1);
  auto simulated = start_simulated(1);  // ends the watched job first
  EXPECT_TRUE(eventually([&] {
    for (std::size_t i = 0; i < watchers.size(); ++i)
      if (i % 5 != 0 && watchers[i]->events() < 3) return false;  // waiting, running, complete
    return true;
  })) << "a stuck watcher keeps others waiting";
}

// Takes a task and never says a word again: its stream looks open, its lease ends.
TEST_F(ManyJobs, a_worker_that_never_heartbeats_loses_its_task_to_another) {
  QueueClient client(address);
  const std::string job = client.submit(0, 1).at(0);
  SimulatedWorker silent(address, "silent", 1, false);
  ASSERT_TRUE(reaches(job, "running"));
  SimulatedWorker other(address, "other", 1);
  ASSERT_TRUE(reaches(job, "complete", std::chrono::seconds(40)));
  EXPECT_EQ(status(job)["attempts"], 2);
}

}  // namespace
}  // namespace granary::test
