// Stored results that answer a repeated job, and those that are computed again to be compared.
#include <gmock/gmock.h>

#include "tests/unit/server/dispatcher_fixture.h"

namespace granary::server {
namespace {

using testing::HasSubstr;

TEST_F(DispatcherTest, a_repeated_job_gets_the_stored_result_unless_fresh) {
  submit("same");
  auto a = connect("a");
  finish("a", a->last_task());
  const JobId reused = submit("same", 0, false);
  EXPECT_EQ(state(reused), v1::COMPLETE);
  EXPECT_TRUE(dispatcher.find(reused)->reused);
  EXPECT_EQ(dispatcher.find(reused)->result_sha256, "from a");
  const JobId fresh = submit("same", 0, true);
  EXPECT_EQ(state(fresh), v1::RUNNING);
}

TEST_F(DispatcherTest, a_reused_result_says_when_its_output_is_not_that_asked_for) {
  NewJob job;
  job.kind = "discharge";
  job.key = "same physics";
  v1::Scene scene;
  scene.mutable_output()->set_frames(10);
  job.resolved_bytes = scene.SerializeAsString();
  const auto submit_job = [&] { return dispatcher.submit({{job}, ""}, now).value()[0]; };
  submit_job();
  finish("a", connect("a")->last_task());
  const auto last_message = [&](JobId id) { return store.events_after(id, 0).back().message; };
  EXPECT_THAT(last_message(submit_job()), testing::Not(HasSubstr("--fresh")));
  scene.mutable_output()->set_frames(1000);
  job.resolved_bytes = scene.SerializeAsString();
  EXPECT_THAT(last_message(submit_job()), HasSubstr("--fresh"));
}

class AuditTest : public DispatcherTest {
 protected:
  AuditTest() { audited.reload(now); }
  void finish_with_hash(const std::string& hash) {
    v1::TaskFinished message;
    message.set_task(link->last_task());
    message.set_outcome(v1::TaskFinished::COMPLETE);
    message.mutable_artifact()->set_sha256("x");
    message.mutable_result()->set_state_hash(hash);
    audited.task_finished("a", message, now);
    for (const auto& effect : audited.take_effects()) effect();
  }
  std::vector<JobId> submit_same(std::size_t times) {
    NewJob job;
    job.kind = "discharge";
    job.key = "k";
    auto ids = audited.submit(
        {std::vector<NewJob>(times, job), "request " + std::to_string(++requests)}, now);
    for (const auto& effect : audited.take_effects()) effect();
    return ids.value();
  }
  void compute_the_original() {
    v1::WorkerHello hello;
    hello.set_worker_id("a");
    hello.set_slots(1);
    hello.add_kinds("discharge");
    audited.worker_connected(hello, link, now);
    submit_same(1);
    finish_with_hash("first");
  }
  std::vector<JobRecord> audits() {
    std::vector<JobRecord> jobs = store.list_jobs({});
    std::erase_if(jobs, [](const JobRecord& job) { return job.owner != kAuditOwner; });
    return jobs;
  }

  std::shared_ptr<FakeLink> link = std::make_shared<FakeLink>();
  Dispatcher audited{store, {.audit_one_in = 3}};
  int requests = 0;
};

TEST_F(AuditTest, computes_one_in_n_reused_results_again) {
  compute_the_original();
  const std::vector<JobId> ids = submit_same(4);
  for (std::size_t k = 1; k < ids.size(); ++k)
    EXPECT_EQ(ids[k], ids[k - 1] + 1) << "audits stand behind the request";
  ASSERT_EQ(audits().size(), 1u);
  finish_with_hash("first");
  EXPECT_EQ(audits()[0].state, v1::COMPLETE);
  EXPECT_EQ(audited.audits_ended().at("same"), 1u);
}

TEST_F(AuditTest, a_result_that_comes_out_differently_is_an_error_that_names_both) {
  compute_the_original();
  submit_same(3);
  finish_with_hash("second");
  ASSERT_EQ(audits().size(), 1u);
  EXPECT_EQ(audits()[0].state, v1::ERROR);
  EXPECT_THAT(audits()[0].error,
              testing::AllOf(HasSubstr("second"), HasSubstr("first"), HasSubstr("jobs/1")));
}

}  // namespace
}  // namespace granary::server
