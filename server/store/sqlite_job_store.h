// JobStore on SQLite: forwards to one class per group of tables.
#pragma once

#include "server/jobs/job_store.h"
#include "server/store/event_table.h"
#include "server/store/job_table.h"
#include "server/store/resume_table.h"
#include "server/store/task_table.h"
#include "server/store/value_table.h"
#include "server/store/worker_table.h"

namespace granary::server {

class SqliteJobStore : public JobStore {
 public:
  explicit SqliteJobStore(SQLite::Database& connection);

  JobId insert_job(const NewJob& job, std::int64_t submitted_ms) override {
    return jobs_.insert(job, submitted_ms);
  }
  std::optional<JobRecord> find_job(JobId id) override { return jobs_.find(id); }
  void update_job(const JobRecord& job) override { jobs_.update(job); }
  void delete_job(JobId id) override { jobs_.erase(id); }
  std::vector<JobRecord> list_jobs(const ListFilter& filter) override { return jobs_.list(filter); }
  std::map<std::string, std::uint64_t> waiting_by_owner() override {
    return jobs_.waiting_by_owner();
  }
  std::uint64_t count_running() override { return jobs_.count_running(); }
  std::map<QueueClass, std::uint64_t> waiting_by_class() override { return jobs_.waiting_by_class(); }
  std::optional<JobRecord> next_waiting(const std::vector<QueueClass>& classes) override {
    return jobs_.next_waiting(classes);
  }
  std::optional<JobRecord> find_complete(const std::string& key) override {
    return jobs_.find_complete(key);
  }

  TaskId insert_task(JobId job, const std::string& worker, std::int64_t started_ms) override {
    return tasks_.insert(job, worker, started_ms);
  }
  void end_task(TaskId task, std::int64_t ended_ms, std::string_view outcome,
                std::string_view message) override {
    tasks_.end(task, ended_ms, outcome, message);
  }
  std::vector<TaskRecord> open_tasks() override { return tasks_.open(); }

  void put_result(JobId job, const v1::Result& result) override { values_.put(job, result); }
  std::optional<v1::Result> find_result(JobId job) override { return values_.find(job); }
  void share_result(JobId from, JobId to) override { values_.share(from, to); }
  void put_series(JobId job, const v1::SeriesList& series) override {
    values_.put_series(job, series);
  }
  void put_worker(const WorkerRecord& worker) override { workers_.put(worker); }
  void mark_workers_lost() override { workers_.mark_all_lost(); }

  void put_resume_files(JobId job, const std::vector<ResumeFileRecord>& files) override {
    resume_.put_files(job, files);
  }
  std::vector<ResumeFileRecord> resume_files(JobId job) override { return resume_.files(job); }
  void put_filling(const std::string& key, const StoredArtifact& artifact,
                   std::int64_t now_ms) override {
    resume_.put_filling(key, artifact, now_ms);
  }
  std::optional<StoredArtifact> find_filling(const std::string& key) override {
    return resume_.find_filling(key);
  }
  std::vector<JobAge> ages_after(JobId after, std::uint32_t limit) override {
    return jobs_.ages_after(after, limit);
  }
  void forget_before(std::int64_t wall_ms) override;
  std::vector<std::string> referenced_artifacts() override { return resume_.referenced(); }

  void append_event(JobId job, const EventRecord& event) override { events_.append(job, event); }
  std::vector<EventRecord> events_after(JobId job, std::uint64_t sequence) override {
    return events_.after(job, sequence);
  }
  void append_logs(JobId job, const std::vector<std::string>& lines) override {
    events_.append_logs(job, lines);
  }
  std::vector<std::string> logs(JobId job) override { return events_.logs(job); }

  std::optional<std::vector<JobId>> find_request(const std::string& request_id) override;
  void put_request(const std::string& request_id, const std::vector<JobId>& jobs,
                   std::int64_t now_ms) override;
  std::uint64_t next_epoch() override;

 private:
  SQLite::Database& connection_;
  JobTable jobs_;
  TaskTable tasks_;
  ValueTable values_;
  EventTable events_;
  ResumeTable resume_;
  WorkerTable workers_;
  SQLite::Statement find_request_, put_request_;
};

}  // namespace granary::server
