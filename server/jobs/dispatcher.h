// The brain of the queue: what happens on submission, assignment, progress, end, loss, cancel. Runs
// on the owner thread only, inside one transaction per batch of requests; the clock is an argument.
// Messages to workers and watchers are effects: they leave only after the commit. When a commit
// fails, the memory of this class is rebuilt from the database, which is the truth.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "proto/contract/result.h"
#include "server/jobs/job_store.h"
#include "server/jobs/queue_tally.h"
#include "server/jobs/retry_policy.h"
#include "server/jobs/watch_hub.h"
#include "server/workers/lease_table.h"
#include "server/workers/worker_registry.h"

namespace granary::server {

// Who submits the recomputations that check stored results.
inline constexpr const char* kAuditOwner = "granary-audit";

struct QueueLimits {
  std::uint64_t max_waiting = 2'000'000;
  std::uint64_t max_waiting_per_owner = 2'000'000;
  // One in so many jobs answered from the store is computed again, behind everything else, and
  // compared; 0 = none.
  std::uint32_t audit_one_in = 0;
};

struct Submission {
  std::vector<NewJob> jobs;
  std::string request_id;
};

class Dispatcher {
 public:
  Dispatcher(JobStore& store, QueueLimits limits);

  // Loads open tasks and gives each a full lease. Call once at start and after a failed commit.
  void reload(Now now);

  // ---- users
  Result<std::vector<JobId>> submit(const Submission& submission, Now now);
  // Jobs of a study: bounded by the study itself, so the limits of the queue do not apply.
  Result<JobId> submit_trial(NewJob job, Now now);
  Result<JobRecord> cancel(JobId id, Now now);
  Result<JobRecord> retry(JobId id, Now now);
  Status remove(JobId id);
  Result<JobRecord> find(JobId id);
  Status watch(JobId id, std::uint64_t after_sequence, std::shared_ptr<Watcher> watcher);
  void unwatch(JobId id, const Watcher* watcher);
  const v1::JobEvent* progress(JobId id) const { return hub_.progress(id); }

  // ---- workers
  void worker_connected(const v1::WorkerHello& hello, std::shared_ptr<WorkerLink> link, Now now);
  void worker_disconnected(const std::string& worker_id, const WorkerLink* link, Now now);
  void heartbeat(const std::string& worker_id, const v1::WorkerHeartbeat& message, Now now);
  void task_progress(const std::string& worker_id, const v1::TaskProgress& message, Now now);
  void task_checkpointed(const std::string& worker_id, const v1::TaskCheckpointed& message, Now now);
  void filling_stored(const std::string& worker_id, const v1::FillingStored& message, Now now);
  void task_finished(const std::string& worker_id, const v1::TaskFinished& message, Now now);
  // May this worker still deliver for this task? An upload or a result of anyone else is refused.
  bool holds(TaskId task) const { return leases_.find(task) != nullptr; }

  // Every worker comes back with what it holds and tells its results again: what it said last may
  // have been lost with a failed commit. At once, not after a commit.
  void close_links();

  // ---- time
  void tick(Now now);  // expired leases, forgotten workers, jobs waiting for a slot
  bool idle() const;   // nobody watches, nothing waits or runs

  std::vector<v1::WorkerInfo> list_workers(Now now);
  // Why nothing new is accepted at present; empty = accepting. Running jobs go on.
  void set_intake_refusal(std::string reason) { intake_refusal_ = std::move(reason); }
  const QueueTally& tally() const { return tally_; }
  std::uint32_t free_slots();
  // Executions ended since the start, by outcome.
  const std::map<std::string, std::uint64_t>& executions_ended() const { return executions_ended_; }
  // Recomputed stored results since the start: "same" and "different".
  const std::map<std::string, std::uint64_t>& audits_ended() const { return audits_ended_; }

  // Studies whose jobs have ended since the last call.
  std::set<StudyId> take_studies_to_advance() { return std::exchange(studies_to_advance_, {}); }

  // Effects of the present batch, to be run after its commit or dropped.
  std::vector<std::function<void()>> take_effects() { return std::exchange(effects_, {}); }

 private:
  std::optional<Error> queue_is_full(const Submission& submission) const;
  std::vector<QueueClass> waiting_for(const Worker& worker) const;
  void fill_slots(Now now);
  void assign(Worker& worker, JobRecord job, Now now);
  v1::ServerMessage assignment_of(const JobRecord& job);
  void end_execution(JobRecord job, ExecutionEnd end, const std::string& message, Now now);
  void store_state(JobRecord& job, const std::string& message, Now now);
  JobId insert(const NewJob& job, Now now);
  void answer_from_store(JobId id, const NewJob& job, const JobRecord& stored, Now now);
  void insert_audits(Now now);
  void compare_with_audited(const JobRecord& audit, const v1::Result& result, ExecutionEnd& end,
                            std::string& message);
  void send(const std::string& worker_id, v1::ServerMessage message);
  void drop(const std::string& worker_id, TaskId task);
  void acknowledge(const std::string& worker_id, TaskId task);
  void record_worker(const std::string& worker_id, Now now);
  std::uint32_t busy_slots(const Worker& worker) const;
  std::uint64_t next_sequence() { return (epoch_ << 40) + ++events_; }

  JobStore& store_;
  QueueLimits limits_;
  LeaseTable leases_;
  WorkerRegistry registry_;
  WatchHub hub_;
  QueueTally tally_;
  std::string intake_refusal_;
  std::map<std::string, std::uint64_t> executions_ended_;
  std::uint64_t reuses_ = 0;
  std::vector<NewJob> audits_;  // to be queued behind the present submission
  std::map<std::string, std::uint64_t> audits_ended_;
  std::uint64_t epoch_ = 0;
  std::uint64_t events_ = 0;
  bool slots_may_be_free_ = true;
  std::set<StudyId> studies_to_advance_;
  std::vector<std::function<void()>> effects_;
};

}  // namespace granary::server
