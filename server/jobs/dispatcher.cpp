#include "server/jobs/dispatcher.h"

#include <algorithm>
#include <utility>

#include "proto/contract/job_state.h"
#include "server/jobs/messages.h"
#include "server/jobs/stored_filling.h"
#include "server/jobs/worker_needs.h"

namespace granary::server {
namespace {

constexpr std::int64_t kForgetLostWorkerMs = 3'600'000;
constexpr int kQueueMovesOnMs = 2000;

Error not_found(JobId id) {
  return {ErrorCode::not_found, "no job " + job_name(id), "name"};
}

constexpr const char* kAuditTag = "audit_of";

// Computed from nothing: not from the filling that the stored result came from, if that can be had
// anew.
NewJob audit_of(const NewJob& job, JobId stored) {
  NewJob audit = job;
  audit.fresh = true;
  audit.owner = kAuditOwner;
  audit.priority = -100;
  audit.tags = {{kAuditTag, job_name(stored)}};
  audit.study = 0;
  if (!job.wants_stored_filling) audit.filling_key.clear();
  return audit;
}

// The key leaves out what a result file holds besides the physics.
bool same_output(const std::string& resolved, const std::string& stored) {
  v1::Scene asked, had;
  if (!asked.ParseFromString(resolved) || !had.ParseFromString(stored)) return true;
  return asked.output().SerializeAsString() == had.output().SerializeAsString();
}

// It becomes a file of that name on another worker: nothing that could leave its folder.
bool is_plain_file_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && name[0] != '.' &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-") ==
             std::string::npos;
}

}  // namespace

Dispatcher::Dispatcher(JobStore& store, QueueLimits limits) : store_(store), limits_(limits) {}

void Dispatcher::reload(Now now) {
  if (epoch_ == 0) {
    epoch_ = store_.next_epoch();
    store_.mark_workers_lost();
  }
  leases_.clear();
  for (const TaskRecord& task : store_.open_tasks())
    leases_.grant(task.id, task.job, task.worker, now.steady_ms);
  audits_.clear();
  tally_.load(store_.waiting_by_owner(), store_.waiting_by_class(), store_.count_running());
  effects_.clear();
  studies_to_advance_.clear();
  slots_may_be_free_ = true;
}

// ------------------------------------------------------------------------------------------- users

JobId Dispatcher::insert(const NewJob& job, Now now) {
  const JobId id = store_.insert_job(job, now.wall_ms);
  const auto stored = job.fresh ? std::nullopt : store_.find_complete(job.key);
  if (!stored) {
    tally_.job_waits(job.owner, {job.kind, job.needs});
    slots_may_be_free_ = true;
    store_.append_event(id, {next_sequence(), now.wall_ms, v1::WAITING, ""});
    return id;
  }
  answer_from_store(id, job, *stored, now);
  return id;
}

void Dispatcher::answer_from_store(JobId id, const NewJob& job, const JobRecord& stored, Now now) {
  JobRecord record = *store_.find_job(id);
  record.state = v1::COMPLETE;
  record.reused = true;
  record.started_ms = record.ended_ms = now.wall_ms;
  record.result_sha256 = stored.result_sha256;
  record.result_bytes = stored.result_bytes;
  store_.share_result(stored.id, id);
  store_.update_job(record);
  std::string message = "stored result of " + job_name(stored.id);
  if (!same_output(job.resolved_bytes, store_.find_job(stored.id)->resolved_bytes))
    message += ", with its frames and series (--fresh computes those asked for)";
  store_.append_event(id, {next_sequence(), now.wall_ms, v1::COMPLETE, message});
  if (limits_.audit_one_in > 0 && ++reuses_ % limits_.audit_one_in == 0)
    audits_.push_back(audit_of(job, stored.id));
}

// Behind the submission that caused them: the jobs of one request have consecutive ids.
void Dispatcher::insert_audits(Now now) {
  for (const NewJob& audit : std::exchange(audits_, {})) insert(audit, now);
}

// A stored result that cannot be had again is a fault of a machine or of the engine: told as an
// error.
void Dispatcher::compare_with_audited(const JobRecord& audit, const v1::Result& result,
                                      ExecutionEnd& end, std::string& message) {
  const auto audited = audit.owner == kAuditOwner ? audit.tags.find(kAuditTag) : audit.tags.end();
  if (audited == audit.tags.end()) return;
  const auto original = store_.find_result(job_id_from(audited->second).value_or(0));
  if (!original) return;
  const bool same = original->state_hash() == result.state_hash();
  ++audits_ended_[same ? "same" : "different"];
  message = same ? "same state_hash as " + audited->second
                 : "state_hash " + result.state_hash() + " differs from " + original->state_hash() +
                       " of " + audited->second;
  if (!same) end = ExecutionEnd::error;
}

// Limits keep one user from filling the disk, and one user's queue from starving the others' intake.
std::optional<Error> Dispatcher::queue_is_full(const Submission& submission) const {
  const auto full = [](const std::string& whose, std::uint64_t limit) {
    return Error{ErrorCode::resource_exhausted,
                 whose + " is full (" + std::to_string(limit) + " waiting jobs): nothing was queued, try again later", "",
                 kQueueMovesOnMs};
  };
  if (tally_.waiting() + submission.jobs.size() > limits_.max_waiting)
    return full("the queue", limits_.max_waiting);
  const std::string& owner = submission.jobs.empty() ? std::string() : submission.jobs[0].owner;
  if (tally_.waiting_of(owner) + submission.jobs.size() > limits_.max_waiting_per_owner)
    return full("the queue of " + owner, limits_.max_waiting_per_owner);
  return {};
}

Result<std::vector<JobId>> Dispatcher::submit(const Submission& submission, Now now) {
  if (!submission.request_id.empty())
    if (auto earlier = store_.find_request(submission.request_id)) return *earlier;
  if (!intake_refusal_.empty()) return Error{ErrorCode::resource_exhausted, intake_refusal_, ""};
  if (auto full = queue_is_full(submission)) return *full;
  std::vector<NewJob> filled;  // those that start from another job's filling
  for (const NewJob& job : submission.jobs) {
    if (!job.wants_stored_filling) continue;
    filled.push_back(job);
    if (Status status = take_stored_filling(store_, filled.back()); !status) return status.error();
  }
  std::vector<JobId> ids;
  ids.reserve(submission.jobs.size());
  auto next = filled.begin();
  for (const NewJob& job : submission.jobs)
    ids.push_back(insert(job.wants_stored_filling ? *next++ : job, now));
  if (!submission.request_id.empty()) store_.put_request(submission.request_id, ids, now.wall_ms);
  insert_audits(now);
  fill_slots(now);
  return ids;
}

Result<JobId> Dispatcher::submit_trial(NewJob job, Now now) {
  if (job.wants_stored_filling)
    if (Status status = take_stored_filling(store_, job); !status) return status.error();
  const JobId id = insert(job, now);
  insert_audits(now);
  fill_slots(now);
  return id;
}

Result<JobRecord> Dispatcher::find(JobId id) {
  auto job = store_.find_job(id);
  if (!job) return not_found(id);
  return *job;
}

Result<JobRecord> Dispatcher::cancel(JobId id, Now now) {
  auto job = store_.find_job(id);
  if (!job) return not_found(id);
  if (job->state == v1::WAITING) {
    tally_.job_waits_no_more(job->owner, {job->kind, job->needs});
    job->cancel_requested = true;
    job->state = v1::CANCELLED;
    job->error = "cancelled";
    job->ended_ms = now.wall_ms;
    store_state(*job, "cancelled while waiting", now);
  } else if (job->state == v1::RUNNING) {
    job->cancel_requested = true;
    store_.update_job(*job);
    send(job->worker, cancel_message(job->task, "cancelled"));
  }
  return *job;
}

Result<JobRecord> Dispatcher::retry(JobId id, Now now) {
  auto job = store_.find_job(id);
  if (!job) return not_found(id);
  if (job->state != v1::ERROR && job->state != v1::UNSTABLE && job->state != v1::CANCELLED)
    return Error{ErrorCode::failed_precondition,
                 job_name(id) + " is " + std::string(to_string(job->state)) +
                     "; only error, unstable and cancelled jobs can be retried",
                 "name"};
  job->state = v1::WAITING;
  job->cancel_requested = job->timed_out = false;
  job->lost_workers = job->engine_crashes = 0;
  job->error.clear();
  job->ended_ms = 0;
  tally_.job_waits(job->owner, {job->kind, job->needs});
  store_state(*job, "retried", now);
  fill_slots(now);
  return *job;
}

Status Dispatcher::remove(JobId id) {
  auto job = store_.find_job(id);
  if (!job) return not_found(id);
  if (!is_final(job->state))
    return Error{ErrorCode::failed_precondition,
                 job_name(id) + " is " + std::string(to_string(job->state)) + "; cancel it first",
                 "name"};
  store_.delete_job(id);
  return Done{};
}

Status Dispatcher::watch(JobId id, std::uint64_t after_sequence, std::shared_ptr<Watcher> watcher) {
  const auto job = store_.find_job(id);
  if (!job) return not_found(id);
  std::vector<v1::JobEvent> backlog;
  for (const EventRecord& record : store_.events_after(id, after_sequence))
    backlog.push_back(to_event(record));
  const bool ended = is_final(job->state);
  // After the commit, so that a watcher sees each event of this batch once and in order.
  effects_.push_back([this, id, ended, backlog = std::move(backlog), watcher = std::move(watcher)] {
    for (const v1::JobEvent& event : backlog) watcher->deliver(event);
    if (ended) return watcher->finish();
    if (const v1::JobEvent* progress = hub_.progress(id)) watcher->deliver(*progress);
    hub_.subscribe(id, watcher);
  });
  return Done{};
}

void Dispatcher::unwatch(JobId id, const Watcher* watcher) {
  hub_.unsubscribe(id, watcher);
}

// ----------------------------------------------------------------------------------------- workers

void Dispatcher::worker_connected(const v1::WorkerHello& hello, std::shared_ptr<WorkerLink> link,
                                  Now now) {
  if (auto old = registry_.connect(hello, std::move(link), now.steady_ms))
    effects_.push_back([old = std::move(old)] { old->close(); });
  record_worker(hello.worker_id(), now);
  send(hello.worker_id(), welcome_message());
  std::vector<TaskId> held;
  for (const v1::HeldTask& task : hello.held()) {
    const auto id = task_id_from(task.task());
    if (id && leases_.renew(*id, hello.worker_id(), now.steady_ms))
      held.push_back(*id);
    else if (id)
      drop(hello.worker_id(), *id);
  }
  // What it should hold but does not was assigned in a message that never arrived.
  for (const Lease& lease : leases_.of_worker(hello.worker_id())) {
    if (std::find(held.begin(), held.end(), lease.task) != held.end()) continue;
    end_execution(*store_.find_job(lease.job), ExecutionEnd::released, "assignment lost", now);
  }
  slots_may_be_free_ = true;
  fill_slots(now);
}

void Dispatcher::worker_disconnected(const std::string& worker_id, const WorkerLink* link,
                                     Now now) {
  if (!registry_.disconnect(worker_id, link)) return;
  leases_.shorten(worker_id, now.steady_ms);
  record_worker(worker_id, now);
}

void Dispatcher::close_links() {
  for (auto& [id, worker] : registry_.all())
    if (auto link = std::exchange(worker.link, nullptr)) link->close();
}

void Dispatcher::heartbeat(const std::string& worker_id, const v1::WorkerHeartbeat& message,
                           Now now) {
  registry_.seen(worker_id, now.steady_ms);
  if (const Worker* worker = registry_.find(worker_id); worker && worker->draining != message.draining()) {
    registry_.set_draining(worker_id, message.draining());
    record_worker(worker_id, now);
  }
  for (const v1::HeldTask& task : message.held()) {
    const auto id = task_id_from(task.task());
    if (id && !leases_.renew(*id, worker_id, now.steady_ms)) drop(worker_id, *id);
  }
}

void Dispatcher::task_progress(const std::string& worker_id, const v1::TaskProgress& message,
                               Now now) {
  const auto task = task_id_from(message.task());
  registry_.seen(worker_id, now.steady_ms);
  if (!task) return;
  if (!leases_.renew(*task, worker_id, now.steady_ms)) return drop(worker_id, *task);
  const JobId job = leases_.find(*task)->job;
  v1::JobEvent event;
  event.set_sequence(next_sequence());
  put_time(now.wall_ms, event.mutable_time());
  *event.mutable_progress() = message.progress();
  hub_.set_progress(job, event);
  hub_.publish(job, event);
}

void Dispatcher::task_checkpointed(const std::string& worker_id,
                                   const v1::TaskCheckpointed& message, Now now) {
  const auto task = task_id_from(message.task());
  if (!task || !leases_.renew(*task, worker_id, now.steady_ms)) return;
  std::vector<ResumeFileRecord> files;
  for (const v1::ResumeFile& file : message.files()) {
    if (!is_plain_file_name(file.name())) return;
    files.push_back({file.name(), to_stored(file.artifact())});
  }
  store_.put_resume_files(leases_.find(*task)->job, files);
}

void Dispatcher::filling_stored(const std::string& worker_id, const v1::FillingStored& message,
                                Now now) {
  const auto task = task_id_from(message.task());
  if (!task || !leases_.renew(*task, worker_id, now.steady_ms)) return;
  const auto job = store_.find_job(leases_.find(*task)->job);
  // Only under the key of its own job: a worker cannot plant a filling for others.
  if (!job || job->filling_key.empty() || job->filling_key != message.filling_key()) return;
  store_.put_filling(job->filling_key, to_stored(message.artifact()), now.wall_ms);
}

void Dispatcher::task_finished(const std::string& worker_id, const v1::TaskFinished& message,
                               Now now) {
  const auto task = task_id_from(message.task());
  registry_.seen(worker_id, now.steady_ms);
  if (!task) return;
  // Of an earlier execution, or told a second time after its acknowledgement was lost.
  const Lease* lease = leases_.find(*task);
  if (!lease || lease->worker != worker_id) return acknowledge(worker_id, *task);
  JobRecord job = *store_.find_job(lease->job);
  ExecutionEnd end = execution_end_of(message.outcome());
  if (end == ExecutionEnd::complete) {
    job.result_sha256 = message.artifact().sha256();
    job.result_bytes = message.artifact().size_bytes();
  }
  if (message.has_result()) store_.put_result(job.id, message.result());
  if (end == ExecutionEnd::complete) store_.put_series(job.id, message.series());
  std::string said = message.message();
  if (end == ExecutionEnd::complete) compare_with_audited(job, message.result(), end, said);
  store_.append_logs(job.id, {message.log_lines().begin(), message.log_lines().end()});
  end_execution(std::move(job), end, said, now);
  acknowledge(worker_id, *task);
  fill_slots(now);
}

void Dispatcher::end_execution(JobRecord job, ExecutionEnd end, const std::string& message,
                               Now now) {
  const TaskId task = job.task;
  store_.end_task(task, now.wall_ms, outcome_text(end), message);
  leases_.end(task);
  ++executions_ended_[std::string(outcome_text(end))];
  tally_.job_runs_no_more();
  apply_execution_end(job, end, message, now);
  if (is_final(job.state)) store_.put_resume_files(job.id, {});
  if (job.state == v1::WAITING) tally_.job_waits(job.owner, {job.kind, job.needs});
  slots_may_be_free_ = true;
  store_state(job, message, now);
}

void Dispatcher::assign(Worker& worker, JobRecord job, Now now) {
  job.task = store_.insert_task(job.id, worker.hello.worker_id(), now.wall_ms);
  job.worker = worker.hello.worker_id();
  job.state = v1::RUNNING;
  job.error.clear();
  ++job.attempts;
  if (job.started_ms == 0) job.started_ms = now.wall_ms;
  tally_.job_waits_no_more(job.owner, {job.kind, job.needs});
  tally_.job_runs();
  leases_.grant(job.task, job.id, job.worker, now.steady_ms);
  store_state(job, "on " + job.worker, now);
  send(job.worker, assignment_of(job));
}

v1::ServerMessage Dispatcher::assignment_of(const JobRecord& job) {
  return assignment_message(
      job, store_.resume_files(job.id),
      job.filling_key.empty() ? std::nullopt : store_.find_filling(job.filling_key));
}

// The classes of waiting jobs that this worker can run: few, however many jobs wait.
std::vector<QueueClass> Dispatcher::waiting_for(const Worker& worker) const {
  const auto& kinds = worker.hello.kinds();
  const Tags tags(worker.hello.tags().begin(), worker.hello.tags().end());
  std::vector<QueueClass> classes;
  for (const auto& [job_class, count] : tally_.classes())
    if (std::find(kinds.begin(), kinds.end(), job_class.kind) != kinds.end() && fulfils(tags, job_class.needs))
      classes.push_back(job_class);
  return classes;
}

void Dispatcher::fill_slots(Now now) {
  if (!slots_may_be_free_) return;
  for (auto& [id, worker] : registry_.all()) {
    if (!worker.link || worker.draining) continue;
    while (busy_slots(worker) < worker.hello.slots()) {
      const std::vector<QueueClass> classes = waiting_for(worker);
      if (classes.empty()) break;
      auto job = store_.next_waiting(classes);
      if (!job) break;
      assign(worker, std::move(*job), now);
    }
  }
  slots_may_be_free_ = tally_.waiting() == 0 || free_slots() > 0;
}

void Dispatcher::store_state(JobRecord& job, const std::string& message, Now now) {
  store_.update_job(job);
  if (job.study != 0 && is_final(job.state)) studies_to_advance_.insert(job.study);
  const EventRecord record{next_sequence(), now.wall_ms, job.state, message};
  store_.append_event(job.id, record);
  effects_.push_back([this, id = job.id, state = job.state, event = to_event(record)] {
    hub_.publish(id, event);
    if (state != v1::RUNNING) hub_.forget_progress(id);
    if (is_final(state)) hub_.finish(id);
  });
}

// -------------------------------------------------------------------------------------------- time

void Dispatcher::tick(Now now) {
  for (const Lease& lease : leases_.expired(now.steady_ms)) {
    auto job = store_.find_job(lease.job);
    if (job && job->task == lease.task)
      end_execution(std::move(*job), ExecutionEnd::worker_lost,
                    "worker " + lease.worker + " was lost", now);
    else
      leases_.end(lease.task);
    drop(lease.worker, lease.task);
    // Silent for a whole lease: a stream that still looks open leads nowhere.
    if (Worker* worker = registry_.find(lease.worker); worker && worker->link) {
      effects_.push_back([link = std::exchange(worker->link, nullptr)] { link->close(); });
      record_worker(lease.worker, now);
    }
  }
  registry_.forget_older_than(now.steady_ms - kForgetLostWorkerMs);
  fill_slots(now);
}

bool Dispatcher::idle() const {
  return tally_.waiting() == 0 && tally_.running() == 0 && hub_.watcher_count() == 0;
}

void Dispatcher::record_worker(const std::string& worker_id, Now now) {
  if (const Worker* worker = registry_.find(worker_id))
    store_.put_worker(worker_record(worker_id, *worker, now));
}

std::vector<v1::WorkerInfo> Dispatcher::list_workers(Now now) {
  std::vector<v1::WorkerInfo> out;
  for (const auto& [id, worker] : registry_.all()) {
    v1::WorkerInfo info = worker_info(id, worker, now);
    info.set_busy(busy_slots(worker));
    for (const Lease& lease : leases_.of_worker(id)) info.add_tasks(job_name(lease.job));
    out.push_back(std::move(info));
  }
  return out;
}

std::uint32_t Dispatcher::free_slots() {
  std::uint32_t free = 0;
  for (const auto& [id, worker] : registry_.all())
    if (worker.link && !worker.draining)
      free += worker.hello.slots() - std::min(worker.hello.slots(), busy_slots(worker));
  return free;
}

std::uint32_t Dispatcher::busy_slots(const Worker& worker) const {
  return leases_.count_of(worker.hello.worker_id());
}

void Dispatcher::send(const std::string& worker_id, v1::ServerMessage message) {
  const Worker* worker = registry_.find(worker_id);
  if (!worker || !worker->link) return;
  effects_.push_back([link = worker->link, message = std::move(message)]() mutable {
    link->send(std::move(message));
  });
}

void Dispatcher::drop(const std::string& worker_id, TaskId task) {
  send(worker_id, drop_message(task));
}

void Dispatcher::acknowledge(const std::string& worker_id, TaskId task) {
  send(worker_id, acknowledged_message(task));
}

}  // namespace granary::server
