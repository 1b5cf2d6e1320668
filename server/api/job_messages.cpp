#include "server/api/job_messages.h"

#include "server/jobs/new_job.h"
#include "server/jobs/worker_needs.h"

namespace granary::server {
v1::Job to_message(const JobRecord& job) {
  v1::Job message;
  message.set_name(job_name(job.id));
  message.set_kind(job.kind);
  message.set_state(job.state);
  if (!job.scene_bytes.empty()) message.mutable_scene()->ParseFromString(job.scene_bytes);
  for (const auto& [name, value] : job.tags) (*message.mutable_tags())[name] = value;
  message.set_priority(job.priority);
  message.set_owner(job.owner);
  message.set_key(job.key);
  put_time(job.submitted_ms, message.mutable_submitted());
  if (job.started_ms > 0) put_time(job.started_ms, message.mutable_started());
  if (job.ended_ms > 0) put_time(job.ended_ms, message.mutable_ended());
  message.set_attempts(job.attempts);
  message.set_worker(job.worker);
  message.set_error(job.error);
  message.set_time_limit_s(job.time_limit_s);
  message.set_reused(job.reused);
  message.set_timed_out(job.timed_out);
  for (const auto& [name, value] : tags_of_needs(job.needs)) (*message.mutable_worker_tags())[name] = value;
  if (job.study != 0) message.set_study(study_name(job.study));
  if (!job.result_sha256.empty()) {
    message.mutable_result()->set_sha256(job.result_sha256);
    message.mutable_result()->set_size_bytes(job.result_bytes);
  }
  return message;
}

Result<NewJob> to_new_job(const v1::SubmitJobsRequest::Item& item, const std::string& owner) {
  auto made = new_job_of(item.scene());
  if (!made) return made.error();
  NewJob& job = *made;
  const Tags worker_tags(item.worker_tags().begin(), item.worker_tags().end());
  if (Status status = check_worker_tags(worker_tags); !status) return status.error();
  job.needs = needs_text(worker_tags);
  job.tags = {item.tags().begin(), item.tags().end()};
  job.priority = item.priority();
  job.owner = owner;
  job.time_limit_s = item.time_limit_s();
  job.fresh = item.fresh();
  return made;
}

}  // namespace granary::server
