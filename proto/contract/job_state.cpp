#include "proto/contract/job_state.h"

#include <array>
#include <utility>

namespace granary {
namespace {

constexpr std::array<std::pair<v1::JobState, std::string_view>, 6> kNames = {{
    {v1::WAITING, "waiting"},
    {v1::RUNNING, "running"},
    {v1::COMPLETE, "complete"},
    {v1::ERROR, "error"},
    {v1::UNSTABLE, "unstable"},
    {v1::CANCELLED, "cancelled"},
}};

}  // namespace

std::string_view to_string(v1::JobState state) {
  for (const auto& [value, name] : kNames)
    if (value == state) return name;
  return "unknown";
}

std::optional<v1::JobState> job_state_from(std::string_view text) {
  for (const auto& [value, name] : kNames)
    if (name == text) return value;
  return {};
}

bool is_final(v1::JobState state) {
  return state == v1::COMPLETE || state == v1::ERROR || state == v1::UNSTABLE ||
         state == v1::CANCELLED;
}

ExitCode exit_code_of(v1::JobState state, bool timed_out) {
  if (timed_out) return ExitCode::timed_out;
  switch (state) {
    case v1::ERROR:
      return ExitCode::job_failed;
    case v1::UNSTABLE:
      return ExitCode::unstable;
    case v1::CANCELLED:
      return ExitCode::cancelled;
    default:
      return ExitCode::ok;
  }
}

}  // namespace granary
