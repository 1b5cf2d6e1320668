// What queue policy needs to be kept, and nothing more. server/store implements it on SQLite; tests
// may implement it in memory. All calls of one request happen inside one transaction of the owner
// thread; a call that cannot be done throws, which undoes the whole request.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/records.h"

namespace granary::server {

class JobStore {
 public:
  virtual ~JobStore() = default;

  virtual JobId insert_job(const NewJob& job, std::int64_t submitted_ms) = 0;
  virtual std::optional<JobRecord> find_job(JobId id) = 0;
  virtual void update_job(const JobRecord& job) = 0;  // everything but id, scenes, key, tags
  virtual void delete_job(JobId id) = 0;
  virtual std::vector<JobRecord> list_jobs(
      const ListFilter& filter) = 0;  // newest first, no scenes
  virtual std::map<std::string, std::uint64_t> waiting_by_owner() = 0;
  virtual std::map<QueueClass, std::uint64_t> waiting_by_class() = 0;
  virtual std::uint64_t count_running() = 0;

  // The waiting job to run next: by rank = submission time - 10 min per priority level, so that
  // priorities age. Only jobs of these classes.
  virtual std::optional<JobRecord> next_waiting(const std::vector<QueueClass>& classes) = 0;

  // A complete job with this key, to be reused.
  virtual std::optional<JobRecord> find_complete(const std::string& key) = 0;

  virtual TaskId insert_task(JobId job, const std::string& worker, std::int64_t started_ms) = 0;
  virtual void end_task(TaskId task, std::int64_t ended_ms, std::string_view outcome,
                        std::string_view message) = 0;
  virtual std::vector<TaskRecord> open_tasks() = 0;

  virtual void put_result(JobId job, const v1::Result& result) = 0;
  virtual std::optional<v1::Result> find_result(JobId job) = 0;
  virtual void share_result(JobId from, JobId to) = 0;  // and the series
  virtual void put_series(JobId job, const v1::SeriesList& series) = 0;

  // The last thing known of every worker; at a start nobody is connected.
  virtual void put_worker(const WorkerRecord& worker) = 0;
  virtual void mark_workers_lost() = 0;

  // What another worker needs to continue; cleared when the job ends.
  virtual void put_resume_files(JobId job, const std::vector<ResumeFileRecord>& files) = 0;
  virtual std::vector<ResumeFileRecord> resume_files(JobId job) = 0;

  // Settled fillings by key, shared by every job that asks for the same one.
  virtual void put_filling(const std::string& key, const StoredArtifact& artifact, std::int64_t now_ms) = 0;
  virtual std::optional<StoredArtifact> find_filling(const std::string& key) = 0;

  // Jobs by growing id, at most `limit` of them.
  virtual std::vector<JobAge> ages_after(JobId after, std::uint32_t limit) = 0;
  // Forgets fillings stored and request ids made before this, but for fillings that open jobs ask
  // for.
  virtual void forget_before(std::int64_t wall_ms) = 0;

  // Every artifact that anything still refers to.
  virtual std::vector<std::string> referenced_artifacts() = 0;

  virtual void append_event(JobId job, const EventRecord& event) = 0;
  virtual std::vector<EventRecord> events_after(JobId job, std::uint64_t sequence) = 0;

  virtual void append_logs(JobId job, const std::vector<std::string>& lines) = 0;
  virtual std::vector<std::string> logs(JobId job) = 0;

  // Idempotent submission: the jobs an earlier request with this id made.
  virtual std::optional<std::vector<JobId>> find_request(const std::string& request_id) = 0;
  virtual void put_request(const std::string& request_id, const std::vector<JobId>& jobs,
                           std::int64_t now_ms) = 0;

  // Number of this start of the server; grows by one each time it is called.
  virtual std::uint64_t next_epoch() = 0;
};

}  // namespace granary::server
