// The queue's promises against a real SQLite file in memory, with a clock made by hand.
#include <gmock/gmock.h>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
#include "server/jobs/worker_needs.h"
#include "tests/unit/server/dispatcher_fixture.h"

namespace granary::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST_F(DispatcherTest, gives_waiting_jobs_to_free_slots_in_order) {
  const JobId first = submit(), second = submit(), third = submit();
  auto link = connect("a", 2);
  EXPECT_THAT(link->assigned(), ElementsAre(job_name(first), job_name(second)));
  finish("a", link->last_task());
  EXPECT_EQ(state(second), v1::COMPLETE);
  EXPECT_THAT(link->assigned().back(), job_name(third));
}

// However many jobs wait for a worker that is not there, the others go on.
TEST_F(DispatcherTest, a_job_goes_only_to_a_worker_that_carries_its_tags) {
  NewJob picky;
  picky.kind = "discharge";
  picky.key = "picky";
  picky.needs = needs_text({{"room", "lab"}, {"cpu", "zen5"}});
  ASSERT_TRUE(dispatcher.submit({{picky}, ""}, now).ok());
  settle();
  auto plain = connect("plain");
  EXPECT_THAT(plain->assigned(), ElementsAre());
  const JobId easy = submit();
  EXPECT_THAT(plain->assigned(), ElementsAre(job_name(easy)));
  auto tagged = std::make_shared<FakeLink>();
  v1::WorkerHello hello;
  hello.set_worker_id("tagged");
  hello.set_slots(1);
  hello.add_kinds("discharge");
  (*hello.mutable_tags())["room"] = "lab";
  (*hello.mutable_tags())["cpu"] = "zen5";
  (*hello.mutable_tags())["more"] = "is fine";
  dispatcher.worker_connected(hello, tagged, now);
  settle();
  EXPECT_THAT(tagged->assigned(), ElementsAre("jobs/1"));
}

TEST_F(DispatcherTest, priority_goes_first_but_ages) {
  const JobId old_job = submit();
  now.wall_ms += 11 * 60'000;  // eleven minutes outweigh one level
  submit("k", 1);
  const JobId urgent = submit("k", 5);
  auto link = connect("a", 2);
  EXPECT_THAT(link->assigned(), ElementsAre(job_name(urgent), job_name(old_job)));
}

TEST_F(DispatcherTest, a_lost_worker_s_job_goes_to_another_and_ends_once) {
  const JobId job = submit();
  auto a = connect("a");
  const std::string zombie_task = a->last_task();
  auto b = connect("b");
  dispatcher.worker_disconnected("a", a.get(), now);
  pass(kReconnectMs - 1);
  EXPECT_TRUE(b->assigned().empty());
  pass(1);
  ASSERT_THAT(b->assigned(), ElementsAre(job_name(job)));
  finish("b", b->last_task());
  EXPECT_EQ(state(job), v1::COMPLETE);
  // The zombie comes back and delivers: acknowledged, so that it forgets, but not stored.
  auto again = connect("a", 1, {zombie_task});
  finish("a", zombie_task);
  EXPECT_EQ(dispatcher.find(job)->result_sha256, "from b");
  EXPECT_EQ(again->count([](const auto& m) { return m.has_acknowledged(); }), 1);
  EXPECT_EQ(again->count([](const auto& m) { return m.has_drop(); }), 1);
}

TEST_F(DispatcherTest, a_worker_that_comes_back_in_time_keeps_its_task) {
  const JobId job = submit();
  auto a = connect("a");
  const std::string task = a->last_task();
  dispatcher.worker_disconnected("a", a.get(), now);
  pass(kReconnectMs / 2);
  connect("a", 1, {task});
  pass(kReconnectMs);
  EXPECT_EQ(state(job), v1::RUNNING);
  finish("a", task);
  EXPECT_EQ(state(job), v1::COMPLETE);
  EXPECT_EQ(dispatcher.find(job)->attempts, 1u);
}

TEST_F(DispatcherTest, an_assignment_that_never_arrived_is_given_again) {
  const JobId job = submit();
  connect("a");
  auto again = connect("a", 1, {});  // reconnects knowing nothing of the task
  EXPECT_THAT(again->assigned(), ElementsAre(job_name(job)));
  EXPECT_EQ(dispatcher.find(job)->attempts, 2u);
}

TEST_F(DispatcherTest, a_result_told_twice_is_stored_once) {
  const JobId job = submit();
  auto a = connect("a");
  const std::string task = a->last_task();
  finish("a", task);
  finish("a", task);
  EXPECT_EQ(state(job), v1::COMPLETE);
  EXPECT_EQ(a->count([](const auto& m) { return m.has_acknowledged(); }), 2);
}

TEST_F(DispatcherTest, a_restarted_server_waits_for_its_workers) {
  const JobId job = submit();
  auto a = connect("a");
  const std::string task = a->last_task();
  Dispatcher restarted(store, {100, 50});
  restarted.reload(now);
  pass(0);
  v1::WorkerHello hello;
  hello.set_worker_id("a");
  hello.set_slots(1);
  hello.add_held()->set_task(task);
  restarted.worker_connected(hello, std::make_shared<FakeLink>(), now);
  now.steady_ms += kLeaseMs - 1;
  restarted.tick(now);
  EXPECT_EQ(restarted.find(job)->state, v1::RUNNING);
  v1::TaskFinished finished;
  finished.set_task(task);
  finished.set_outcome(v1::TaskFinished::COMPLETE);
  restarted.task_finished("a", finished, now);
  EXPECT_EQ(restarted.find(job)->state, v1::COMPLETE);
}

TEST_F(DispatcherTest, the_wall_clock_may_jump) {
  const JobId job = submit();
  connect("a");
  now.wall_ms += 86'400'000;
  dispatcher.tick(now);
  EXPECT_EQ(state(job), v1::RUNNING);
  now.wall_ms -= 2 * 86'400'000;
  now.steady_ms += kLeaseMs;
  dispatcher.tick(now);
  EXPECT_EQ(state(job), v1::WAITING);
}

TEST_F(DispatcherTest, cancel_reaches_a_running_engine_and_a_waiting_job) {
  const JobId running = submit(), waiting = submit();
  auto a = connect("a");
  ASSERT_TRUE(dispatcher.cancel(waiting, now).ok());
  EXPECT_EQ(state(waiting), v1::CANCELLED);
  ASSERT_TRUE(dispatcher.cancel(running, now).ok());
  settle();
  EXPECT_EQ(a->count([](const auto& m) { return m.has_cancel(); }), 1);
  EXPECT_EQ(state(running), v1::RUNNING);  // until its engine has stopped
  finish("a", a->last_task(), v1::TaskFinished::CANCELLED);
  EXPECT_EQ(state(running), v1::CANCELLED);
}

TEST_F(DispatcherTest, the_same_request_id_makes_the_same_jobs) {
  NewJob job;
  job.kind = "discharge";
  const Submission submission{{job, job}, "request-1"};
  const auto first = dispatcher.submit(submission, now);
  const auto again = dispatcher.submit(submission, now);
  EXPECT_EQ(*first, *again);
  EXPECT_EQ(dispatcher.tally().waiting(), 2u);
}

TEST_F(DispatcherTest, a_full_queue_refuses_the_whole_batch) {
  Submission submission;
  submission.jobs.resize(101);
  EXPECT_EQ(dispatcher.submit(submission, now).error().code, ErrorCode::resource_exhausted);
  EXPECT_EQ(dispatcher.tally().waiting(), 0u);
}

TEST_F(DispatcherTest, one_owner_s_full_queue_leaves_room_for_others) {
  Submission submission;
  submission.jobs.resize(50);
  for (NewJob& job : submission.jobs) job.owner = "anna";
  ASSERT_TRUE(dispatcher.submit(submission, now).ok());
  submission.jobs.resize(1);
  const auto refused = dispatcher.submit(submission, now);
  EXPECT_EQ(refused.error().code, ErrorCode::resource_exhausted);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("anna"));
  submission.jobs[0].owner = "berta";
  EXPECT_TRUE(dispatcher.submit(submission, now).ok());
  // Room again once a job has left the queue; the count survives a rebuild.
  ASSERT_TRUE(dispatcher.cancel(1, now).ok());
  dispatcher.reload(now);
  submission.jobs[0].owner = "anna";
  EXPECT_TRUE(dispatcher.submit(submission, now).ok());
}

TEST_F(DispatcherTest, a_watcher_sees_each_state_once_and_resumes_behind_a_sequence) {
  const JobId job = submit();
  auto watcher = std::make_shared<RecordingWatcher>();
  ASSERT_TRUE(dispatcher.watch(job, 0, watcher).ok());
  settle();
  auto a = connect("a");
  v1::TaskProgress progress;
  progress.set_task(a->last_task());
  progress.mutable_progress()->set_fraction(0.5);
  dispatcher.task_progress("a", progress, now);
  auto late = std::make_shared<RecordingWatcher>();
  ASSERT_TRUE(dispatcher.watch(job, watcher->events.back().sequence() - 1, late).ok());
  settle();
  finish("a", a->last_task());
  EXPECT_THAT(watcher->states(), ElementsAre(v1::WAITING, v1::RUNNING, v1::COMPLETE));
  EXPECT_TRUE(watcher->finished);
  EXPECT_THAT(late->states(), ElementsAre(v1::COMPLETE));  // RUNNING lies before the sequence
  std::uint64_t last = 0;
  for (const auto& event : watcher->events) {
    EXPECT_GT(event.sequence(), last);
    last = event.sequence();
  }
  auto after_the_end = std::make_shared<RecordingWatcher>();
  ASSERT_TRUE(dispatcher.watch(job, 0, after_the_end).ok());
  settle();
  EXPECT_EQ(after_the_end->states().size(), 3u);
  EXPECT_TRUE(after_the_end->finished);
}

TEST_F(DispatcherTest, sequences_grow_over_a_restart) {
  const JobId job = submit();
  const auto before = store.events_after(job, 0).back().sequence;
  Dispatcher restarted(store, {100, 50});
  restarted.reload(now);
  ASSERT_TRUE(restarted.cancel(job, now).ok());
  EXPECT_GT(store.events_after(job, 0).back().sequence, before);
}

TEST_F(DispatcherTest, only_ended_jobs_can_be_deleted_or_retried) {
  const JobId job = submit();
  EXPECT_EQ(dispatcher.remove(job).error().code, ErrorCode::failed_precondition);
  EXPECT_EQ(dispatcher.retry(job, now).error().code, ErrorCode::failed_precondition);
  ASSERT_TRUE(dispatcher.cancel(job, now).ok());
  EXPECT_TRUE(dispatcher.retry(job, now).ok());
  EXPECT_EQ(state(job), v1::WAITING);
  ASSERT_TRUE(dispatcher.cancel(job, now).ok());
  EXPECT_TRUE(dispatcher.remove(job).ok());
  EXPECT_EQ(dispatcher.find(job).error().code, ErrorCode::not_found);
}

TEST_F(DispatcherTest, the_next_execution_gets_the_last_checkpoint) {
  const JobId job = submit();
  auto a = connect("a");
  const std::string task = a->last_task();
  v1::TaskCheckpointed message;
  message.set_task(task);
  message.add_files()->set_name("checkpoint");
  message.mutable_files(0)->mutable_artifact()->set_sha256("c1");
  dispatcher.task_checkpointed("zombie", message, now);
  EXPECT_TRUE(store.resume_files(job).empty());
  dispatcher.task_checkpointed("a", message, now);
  finish("a", task, v1::TaskFinished::RELEASED);
  const auto& assigned = a->sent.back().has_assign() ? a->sent.back() : a->sent[a->sent.size() - 2];
  ASSERT_EQ(assigned.assign().resume_files_size(), 1);
  EXPECT_EQ(assigned.assign().resume_files(0).artifact().sha256(), "c1");
  finish("a", a->last_task());
  EXPECT_TRUE(store.resume_files(job).empty()) << "nothing is kept for a job that has ended";
}

TEST_F(DispatcherTest, resume_files_that_would_leave_their_folder_are_refused) {
  const JobId job = submit();
  auto a = connect("a");
  for (const char* name : {"../checkpoint", "/etc/passwd", ".hidden", "", "a/b"}) {
    v1::TaskCheckpointed message;
    message.set_task(a->last_task());
    message.add_files()->set_name(name);
    dispatcher.task_checkpointed("a", message, now);
    EXPECT_TRUE(store.resume_files(job).empty()) << name;
  }
}

TEST_F(DispatcherTest, a_filling_is_shared_under_its_own_key_only) {
  NewJob job;
  job.kind = "discharge";
  job.filling_key = "f1";
  job.fresh = true;
  ASSERT_TRUE(dispatcher.submit({{job, job}, ""}, now).ok());
  auto a = connect("a");
  v1::FillingStored stored;
  stored.set_task(a->last_task());
  stored.set_filling_key("of another job");
  stored.mutable_artifact()->set_sha256("planted");
  dispatcher.filling_stored("a", stored, now);
  EXPECT_FALSE(store.find_filling("of another job").has_value());
  stored.set_filling_key("f1");
  stored.mutable_artifact()->set_sha256("settled");
  dispatcher.filling_stored("a", stored, now);
  finish("a", a->last_task());
  v1::TaskAssignment second;
  for (const auto& message : a->sent)
    if (message.has_assign()) second = message.assign();
  EXPECT_EQ(second.filling().sha256(), "settled");
}

// A job that fills a bucket of `wall_m`, and one that starts from what it filled.
NewJob filling_job(const std::string& stored_filling, const std::string& wall_m = "0.08") {
  const auto scene = load_scene(
      "discharge { particles { count: 20 diameter_min_m: 0.004 density_kg_per_m3: 730 } "
      "friction_pp_deg: 30 friction_pw_deg: 30 rotation_rad_per_s: 5 bucket { tip_x_m: -" +
          wall_m + " } " + stored_filling + "}",
      "scene", {});
  const auto resolved = resolve(*scene);
  NewJob job;
  job.kind = "discharge";
  job.resolved_bytes = resolved->scene.SerializeAsString();
  job.filling_key = filling_key(resolved->scene);
  job.wants_stored_filling = !stored_filling.empty();
  job.key = job_key(resolved->scene);
  return job;
}

TEST_F(DispatcherTest, a_stored_filling_is_that_of_the_job_named) {
  const NewJob maker = filling_job("");
  const JobId source = dispatcher.submit({{maker}, ""}, now)->at(0);
  const std::string stored = "filling: STORED stored_filling: \"" + job_name(source) + "\"";
  const auto refusal = [&](const NewJob& job) {
    const auto ids = dispatcher.submit({{job}, ""}, now);
    EXPECT_FALSE(ids.ok());
    EXPECT_EQ(ids.error().field_path, "discharge.stored_filling");
    return ids.error().message;
  };
  EXPECT_THAT(refusal(filling_job(stored)), HasSubstr("has not stored its filling"));
  EXPECT_THAT(refusal(filling_job("filling: STORED stored_filling: \"jobs/99\"")),
              HasSubstr("jobs/99 does not exist"));
  EXPECT_THAT(refusal(filling_job("filling: STORED stored_filling: \"mine\"")),
              HasSubstr("is no job"));
  auto a = connect("a");
  v1::FillingStored message;
  message.set_task(a->last_task());
  message.set_filling_key(maker.filling_key);
  message.mutable_artifact()->set_sha256("settled");
  dispatcher.filling_stored("a", message, now);
  EXPECT_THAT(refusal(filling_job(stored, "0.1")), HasSubstr("another discharge.bucket"));
  finish("a", a->last_task());
  const JobId user = dispatcher.submit({{filling_job(stored)}, ""}, now)->at(0);
  settle();
  EXPECT_EQ(a->sent.back().assign().job(), job_name(user));
  EXPECT_EQ(a->sent.back().assign().filling().sha256(), "settled");
  EXPECT_EQ(a->sent.back().assign().filling_key(), maker.filling_key);
}

TEST_F(DispatcherTest, a_draining_worker_gets_nothing_new) {
  auto a = connect("a", 4);
  v1::WorkerHeartbeat heartbeat;
  heartbeat.set_draining(true);
  dispatcher.heartbeat("a", heartbeat, now);
  submit();
  EXPECT_TRUE(a->assigned().empty());
}

}  // namespace
}  // namespace granary::server
