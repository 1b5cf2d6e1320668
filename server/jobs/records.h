// Plain records of the queue, as policy sees them and the store keeps them. Times: wall clock in
// milliseconds since 1970 for people; leases use the steady clock (lease_table.h).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <google/protobuf/timestamp.pb.h>

#include "granary/v1/job.pb.h"
#include "granary/v1/result.pb.h"
#include "granary/v1/worker.pb.h"

namespace granary::server {

using JobId = std::int64_t;
using StudyId = std::int64_t;
using TaskId = std::int64_t;  // grows with every execution: it is the fencing token

// Both clocks, taken once per request: policy never asks for the time itself.
struct Now {
  std::int64_t wall_ms = 0;
  std::int64_t steady_ms = 0;
};

struct JobRecord {
  JobId id = 0;
  std::string kind;
  v1::JobState state = v1::WAITING;
  std::string scene_bytes;     // v1.Scene as submitted
  std::string resolved_bytes;  // v1.Scene as run
  std::string key;
  std::string filling_key;
  std::string needs;  // worker_needs.h
  std::map<std::string, std::string> tags;
  std::int32_t priority = 0;
  std::string owner;
  std::int64_t submitted_ms = 0;
  std::int64_t started_ms = 0;  // 0 = not yet
  std::int64_t ended_ms = 0;
  std::uint32_t attempts = 0;
  std::uint32_t lost_workers = 0;  // executions that ended with their worker
  std::uint32_t engine_crashes = 0;
  TaskId task = 0;  // current execution; 0 = none
  bool cancel_requested = false;
  std::string worker;
  std::string error;
  bool timed_out = false;
  bool reused = false;
  double time_limit_s = 0;
  std::string result_sha256;
  std::uint64_t result_bytes = 0;
  StudyId study = 0;  // 0 = submitted by itself
};

// Jobs that the same workers can run.
struct QueueClass {
  std::string kind;
  std::string needs;
  auto operator<=>(const QueueClass&) const = default;
};

struct NewJob {
  std::string kind;
  std::string scene_bytes;
  std::string resolved_bytes;
  std::string key;
  std::string filling_key;  // empty: nothing to share
  bool wants_stored_filling = false;
  std::string needs;        // worker_needs.h
  std::map<std::string, std::string> tags;
  std::int32_t priority = 0;
  std::string owner;
  double time_limit_s = 0;
  bool fresh = false;
  StudyId study = 0;
};

struct TaskRecord {
  TaskId id = 0;
  JobId job = 0;
  std::string worker;
  std::int64_t started_ms = 0;
};

struct WorkerRecord {
  std::string id;
  std::string host;
  std::int64_t pid = 0;
  std::uint32_t slots = 0;
  std::string state;  // "connected", "draining", "lost"
  std::string engine_version;
  std::string vector_path;
  std::int64_t seen_ms = 0;  // wall
};

struct EventRecord {
  std::uint64_t sequence = 0;
  std::int64_t time_ms = 0;
  v1::JobState state = v1::WAITING;
  std::string message;
};

// What decides how long a job is kept.
struct JobAge {
  JobId id = 0;
  std::int64_t submitted_ms = 0;
  std::int64_t ended_ms = 0;
  bool removable = false;  // ended, not tagged `keep`, of no study that still goes on
};

struct StoredArtifact {
  std::string sha256;
  std::uint64_t size_bytes = 0;
};

// A file that lets another worker continue a job.
struct ResumeFileRecord {
  std::string name;
  StoredArtifact artifact;
};

struct ListFilter {
  std::string kind;
  std::optional<v1::JobState> state;
  std::map<std::string, std::string> tags;
  JobId before = 0;  // 0 = from the newest
  std::uint32_t limit = 100;
};

void put_time(std::int64_t wall_ms, google::protobuf::Timestamp* time);

std::string study_name(StudyId id);
std::optional<StudyId> study_id_from(const std::string& name);  // "studies/3"
std::string job_name(JobId id);
std::optional<JobId> job_id_from(const std::string& name);  // "jobs/17"
std::string task_name(TaskId id);
std::optional<TaskId> task_id_from(const std::string& name);

}  // namespace granary::server
