// What studies promise, with a scripted generator, a real database in memory and a fake worker.
#include "server/studies/study_director.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "proto/contract/scene_text.h"
#include "server/store/database.h"
#include "server/store/sqlite_job_store.h"
#include "server/store/study_table.h"

namespace granary::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::StudySpec base_spec() {
  v1::StudySpec spec;
  spec.set_name("scripted");
  *spec.mutable_scene() =
      parse_scene(
          "discharge { particles { count: 20 diameter_min_m: 0.01 density_kg_per_m3: 2200 } "
          "friction_pp_deg: 30 friction_pw_deg: 20 rotation_rad_per_s: 10 }",
          "test")
          ->scene;
  spec.mutable_sweep();
  return spec;
}

// Two rounds of three trials: the second one depends on the first being told. The state is the log
// of everything told, so a lost or doubled tell shows.
class ScriptedGenerator : public StudyGenerator {
 public:
  explicit ScriptedGenerator(const v1::StudySpec& spec) : base_(spec.scene()) {}

  std::vector<TrialProposal> ask(std::size_t limit) override {
    std::vector<TrialProposal> proposals;
    while (proposals.size() < limit && proposed_ < 6 && (proposed_ < 3 || told_ >= 3)) {
      TrialProposal proposal;
      proposal.scene = base_;
      proposal.scene.set_seed(static_cast<std::uint64_t>(++proposed_));
      if (proposed_ == 5) proposal.scene.mutable_discharge()->set_friction_pp_deg(-1);  // refused
      proposal.label = "trial " + std::to_string(proposed_);
      proposal.inputs = {{"seed", std::to_string(proposed_)}};
      proposals.push_back(std::move(proposal));
    }
    return proposals;
  }
  TrialJudgement tell(std::uint32_t trial, const TrialOutcome& outcome) override {
    ++told_;
    log_ += std::to_string(trial) + (outcome.state == v1::COMPLETE ? "c" : "f");
    return {1.0 * trial, {}, true};
  }
  bool done() const override { return proposed_ == 6; }
  std::uint32_t planned() const override { return 6; }
  v1::StudySummary summary() const override {
    v1::StudySummary summary;
    summary.set_verdict(log_);
    return summary;
  }
  std::optional<Findings> findings() const override { return Findings{{}, {}, {1}}; }
  std::string save() const override {
    return std::to_string(proposed_) + " " + std::to_string(told_) + " x" + log_;
  }
  void restore(const std::string& bytes) override {
    std::istringstream in(bytes);
    in >> proposed_ >> told_ >> log_;
    log_.erase(0, 1);
  }

 private:
  v1::Scene base_;
  int proposed_ = 0, told_ = 0;
  std::string log_;
};

class FakeLink : public WorkerLink {
 public:
  void send(v1::ServerMessage message) override {
    if (message.has_assign()) tasks.push_back(message.assign());
  }
  void close() override {}
  std::vector<v1::TaskAssignment> tasks;
};

class LastStudy : public StudyWatcher {
 public:
  void deliver(const v1::Study& study) override { last = study; }
  void finish() override { finished = true; }
  v1::Study last;
  bool finished = false;
};

class StudyDirectorTest : public testing::Test {
 protected:
  StudyDirectorTest() {
    restart();
    v1::WorkerHello hello;
    hello.set_worker_id("w");
    hello.set_slots(10);
    hello.add_kinds("discharge");
    dispatcher->worker_connected(hello, link, now);
  }

  // As after kill -9: nothing but the database survives.
  void restart() {
    director.reset();
    if (!dispatcher) {
      dispatcher = std::make_unique<Dispatcher>(store, QueueLimits{});
      dispatcher->reload(now);
    }
    (void)dispatcher->take_studies_to_advance();
    director = std::make_unique<StudyDirector>(
        studies, store, *dispatcher,
        [](const v1::StudySpec& spec) -> Result<std::unique_ptr<StudyGenerator>> {
          return std::unique_ptr<StudyGenerator>(std::make_unique<ScriptedGenerator>(spec));
        });
    director->reload();
  }

  void settle() {
    do director->work(now);
    while (director->has_work());
    for (const auto& effect : dispatcher->take_effects()) effect();
    for (const auto& effect : director->take_effects()) effect();
  }

  StudyId submit() {
    const StudyId id = director->submit({base_spec(), "anna", ""}, now)->id;
    settle();
    return id;
  }

  // The worker ends the task of job number `job`.
  void end(JobId job, v1::TaskFinished::Outcome outcome = v1::TaskFinished::COMPLETE) {
    for (const v1::TaskAssignment& task : link->tasks) {
      if (task.job() != job_name(job)) continue;
      v1::TaskFinished message;
      message.set_task(task.task());
      message.set_outcome(outcome);
      message.mutable_result()->set_kind("discharge");
      dispatcher->task_finished("w", message, now);
    }
    settle();
  }

  StudyRecord record(StudyId id) { return *studies.find_study(id); }

  Now now{1'700'000'000'000, 1000};
  Database database{":memory:"};
  SqliteJobStore store{database.connection()};
  StudyTable studies{database.connection()};
  std::shared_ptr<FakeLink> link = std::make_shared<FakeLink>();
  std::unique_ptr<Dispatcher> dispatcher;
  std::unique_ptr<StudyDirector> director;
};

TEST_F(StudyDirectorTest, proposals_become_jobs_that_carry_the_study) {
  const StudyId id = submit();
  EXPECT_EQ(link->tasks.size(), 3u) << "the second round waits for the first";
  EXPECT_EQ(store.find_job(1)->study, id);
  EXPECT_EQ(store.find_job(1)->owner, "anna");
  EXPECT_EQ(studies.find_trial(id, 2)->job, 2);
  EXPECT_EQ(studies.find_trial(id, 2)->inputs, R"({"seed":"2"})");
}

TEST_F(StudyDirectorTest, outcomes_are_told_in_trial_order_whatever_ends_first) {
  const StudyId id = submit();
  end(3);
  end(2, v1::TaskFinished::UNSTABLE);
  EXPECT_EQ(record(id).told, 0u);
  end(1);
  EXPECT_EQ(record(id).told, 3u);
  EXPECT_EQ(record(id).summary.verdict(), "1c2f3c");
  EXPECT_EQ(record(id).trials, 6u);
}

TEST_F(StudyDirectorTest, failed_and_refused_trials_are_recorded_and_the_study_completes) {
  const StudyId id = submit();
  for (JobId job : {1, 2, 3}) end(job, v1::TaskFinished::ERROR);
  const auto refused = studies.find_trial(id, 5);
  EXPECT_EQ(refused->job, 0);
  EXPECT_THAT(refused->error, HasSubstr("friction_pp_deg"));
  for (JobId job : {4, 5}) end(job);
  EXPECT_EQ(record(id).state, v1::Study::COMPLETE);
  EXPECT_EQ(record(id).summary.verdict(), "1f2f3f4c5f6c");
  EXPECT_EQ(record(id).failed, 4u);
  EXPECT_EQ(*studies.find_trial(id, 4)->objective, 4.0);
  EXPECT_TRUE(studies.find_trial(id, 1)->pareto);
}

TEST_F(StudyDirectorTest, a_killed_server_continues_as_if_nothing_had_happened) {
  const StudyId id = submit();
  for (JobId job : {2, 1, 3, 5, 4}) {
    restart();
    settle();
    end(job);
  }
  EXPECT_EQ(record(id).state, v1::Study::COMPLETE);
  EXPECT_EQ(record(id).summary.verdict(), "1c2c3c4c5f6c");
  EXPECT_EQ(record(id).trials, 6u);
}

TEST_F(StudyDirectorTest, an_end_that_nobody_heard_is_found_after_a_restart) {
  const StudyId id = submit();
  for (JobId job : {1, 2, 3}) {
    v1::TaskFinished message;
    message.set_task(link->tasks[static_cast<std::size_t>(job - 1)].task());
    message.set_outcome(v1::TaskFinished::COMPLETE);
    dispatcher->task_finished("w", message, now);  // and the server dies before it is told
  }
  restart();
  settle();
  EXPECT_EQ(record(id).told, 5u - 2u);
  EXPECT_EQ(record(id).trials, 6u);
}

TEST_F(StudyDirectorTest, a_stored_result_answers_the_trials_of_the_next_study) {
  submit();
  for (JobId job : {1, 2, 3, 4, 5}) end(job);
  link->tasks.clear();
  const StudyId again = submit();
  EXPECT_TRUE(link->tasks.empty());
  EXPECT_EQ(record(again).state, v1::Study::COMPLETE);
  EXPECT_EQ(record(again).reused, 5u);
}

TEST_F(StudyDirectorTest, the_same_request_gives_the_same_study) {
  const StudyId first = director->submit({base_spec(), "anna", "r1"}, now)->id;
  EXPECT_EQ(director->submit({base_spec(), "anna", "r1"}, now)->id, first);
  EXPECT_NE(director->submit({base_spec(), "anna", "r2"}, now)->id, first);
}

TEST_F(StudyDirectorTest, a_paused_study_listens_and_proposes_nothing_until_it_is_resumed) {
  const StudyId id = submit();
  ASSERT_TRUE(director->pause(id, now).ok());
  for (JobId job : {1, 2, 3}) end(job);
  EXPECT_EQ(record(id).told, 3u);
  EXPECT_EQ(record(id).trials, 3u);
  restart();
  settle();
  EXPECT_EQ(record(id).state, v1::Study::PAUSED);
  ASSERT_TRUE(director->resume(id, now).ok());
  settle();
  EXPECT_EQ(record(id).trials, 6u);
}

TEST_F(StudyDirectorTest, cancel_ends_the_study_and_its_waiting_jobs_or_keeps_them) {
  link->tasks.clear();
  dispatcher->worker_disconnected("w", link.get(), now);
  const StudyId with_jobs = submit();
  ASSERT_TRUE(director->cancel(with_jobs, false, now).ok());
  settle();
  EXPECT_EQ(store.find_job(1)->state, v1::CANCELLED);
  EXPECT_EQ(record(with_jobs).state, v1::Study::CANCELLED);
  const StudyId without = submit();
  ASSERT_TRUE(director->cancel(without, true, now).ok());
  EXPECT_EQ(store.find_job(4)->state, v1::WAITING);
  EXPECT_EQ(director->pause(without, now).error().code, ErrorCode::failed_precondition);
  EXPECT_EQ(director->cancel(99, false, now).error().code, ErrorCode::not_found);
}

TEST_F(StudyDirectorTest, a_fixed_plan_cannot_be_extended) {
  const StudyId id = submit();
  EXPECT_EQ(director->extend(id, 10, now).error().code, ErrorCode::failed_precondition);
}

TEST_F(StudyDirectorTest, a_deleted_job_counts_as_a_failed_trial) {
  const StudyId id = submit();
  end(2);
  ASSERT_TRUE(dispatcher->remove(2).ok());
  end(1);
  EXPECT_EQ(record(id).summary.verdict(), "1c2f");
}

TEST_F(StudyDirectorTest, watchers_get_the_latest_state_and_the_end) {
  const StudyId id = submit();
  auto watcher = std::make_shared<LastStudy>();
  ASSERT_TRUE(director->watch(id, watcher).ok());
  settle();
  EXPECT_EQ(watcher->last.trials(), 3u);
  for (JobId job : {1, 2, 3, 4, 5}) end(job);
  EXPECT_EQ(watcher->last.state(), v1::Study::COMPLETE);
  EXPECT_TRUE(watcher->finished);
  EXPECT_TRUE(director->idle());
  EXPECT_EQ(director->watch(99, watcher).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace granary::server
