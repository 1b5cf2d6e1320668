#include "server/jobs/records.h"

#include <charconv>

namespace granary::server {
namespace {

std::optional<std::int64_t> id_after(const std::string& name, std::string_view prefix) {
  if (name.compare(0, prefix.size(), prefix) != 0) return {};
  std::int64_t id = 0;
  const char* end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data() + prefix.size(), end, id);
  if (error != std::errc() || rest != end || id <= 0) return {};
  return id;
}

}  // namespace

void put_time(std::int64_t wall_ms, google::protobuf::Timestamp* time) {
  time->set_seconds(wall_ms / 1000);
  time->set_nanos(static_cast<std::int32_t>(wall_ms % 1000) * 1'000'000);
}

std::string study_name(StudyId id) {
  return "studies/" + std::to_string(id);
}
std::optional<StudyId> study_id_from(const std::string& name) {
  return id_after(name, "studies/");
}
std::string job_name(JobId id) {
  return "jobs/" + std::to_string(id);
}
std::optional<JobId> job_id_from(const std::string& name) {
  return id_after(name, "jobs/");
}
std::string task_name(TaskId id) {
  return "tasks/" + std::to_string(id);
}
std::optional<TaskId> task_id_from(const std::string& name) {
  return id_after(name, "tasks/");
}

}  // namespace granary::server
