// Names of job states as users see them.
#pragma once

#include <optional>
#include <string_view>

#include "granary/v1/job.pb.h"
#include "proto/contract/result.h"

namespace granary {

std::string_view to_string(v1::JobState state);  // "waiting", "running", ...
std::optional<v1::JobState> job_state_from(std::string_view text);
bool is_final(v1::JobState state);
ExitCode exit_code_of(v1::JobState state, bool timed_out);

}  // namespace granary
