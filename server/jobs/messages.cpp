#include "server/jobs/messages.h"

#include "server/jobs/worker_needs.h"
#include "server/workers/lease_table.h"

namespace granary::server {
namespace {

v1::Artifact to_artifact(const StoredArtifact& stored) {
  v1::Artifact artifact;
  artifact.set_sha256(stored.sha256);
  artifact.set_size_bytes(stored.size_bytes);
  return artifact;
}

std::string state_text(const Worker& worker) {
  return !worker.link ? "lost" : worker.draining ? "draining" : "connected";
}

}  // namespace

v1::JobEvent to_event(const EventRecord& record) {
  v1::JobEvent event;
  event.set_sequence(record.sequence);
  put_time(record.time_ms, event.mutable_time());
  event.set_state(record.state);
  event.set_message(record.message);
  return event;
}

StoredArtifact to_stored(const v1::Artifact& artifact) {
  return {artifact.sha256(), artifact.size_bytes()};
}

v1::ServerMessage welcome_message() {
  v1::ServerMessage message;
  message.mutable_welcome()->set_heartbeat_s(kHeartbeatMs / 1000.0);
  message.mutable_welcome()->set_lease_s(kLeaseMs / 1000.0);
  return message;
}

v1::ServerMessage cancel_message(TaskId task, const std::string& reason) {
  v1::ServerMessage message;
  message.mutable_cancel()->set_task(task_name(task));
  message.mutable_cancel()->set_reason(reason);
  return message;
}

v1::ServerMessage drop_message(TaskId task) {
  v1::ServerMessage message;
  message.mutable_drop()->set_task(task_name(task));
  return message;
}

v1::ServerMessage acknowledged_message(TaskId task) {
  v1::ServerMessage message;
  message.mutable_acknowledged()->set_task(task_name(task));
  return message;
}

v1::ServerMessage assignment_message(const JobRecord& job,
                                     const std::vector<ResumeFileRecord>& resume_files,
                                     const std::optional<StoredArtifact>& filling) {
  v1::ServerMessage message;
  v1::TaskAssignment& task = *message.mutable_assign();
  task.set_task(task_name(job.task));
  task.set_fencing_token(static_cast<std::uint64_t>(job.task));
  task.set_job(job_name(job.id));
  task.mutable_scene()->ParseFromString(job.scene_bytes);
  task.set_time_limit_s(job.time_limit_s);
  task.set_attempt(job.attempts);
  for (const ResumeFileRecord& file : resume_files) {
    v1::ResumeFile& resume = *task.add_resume_files();
    resume.set_name(file.name);
    *resume.mutable_artifact() = to_artifact(file.artifact);
  }
  task.set_filling_key(job.filling_key);
  if (filling) *task.mutable_filling() = to_artifact(*filling);
  return message;
}

v1::WorkerInfo worker_info(const std::string& id, const Worker& worker, Now now) {
  v1::WorkerInfo info;
  info.set_worker_id(id);
  info.set_host(worker.hello.host());
  info.set_slots(worker.hello.slots());
  info.set_state(state_text(worker));
  info.set_seconds_since_seen(static_cast<double>(now.steady_ms - worker.seen_ms) / 1000.0);
  info.set_engine_version(worker.hello.engine_version());
  info.set_vector_path(worker.hello.vector_path());
  info.set_pid(worker.hello.pid());
  *info.mutable_tags() = worker.hello.tags();
  return info;
}

WorkerRecord worker_record(const std::string& id, const Worker& worker, Now now) {
  const v1::WorkerHello& hello = worker.hello;
  return {id,
          hello.host(),
          hello.pid(),
          hello.slots(),
          state_text(worker),
          hello.engine_version(),
          hello.vector_path(),
          now.wall_ms};
}

}  // namespace granary::server
