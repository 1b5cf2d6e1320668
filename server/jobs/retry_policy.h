// What becomes of a job when one execution of it ends. Pure: records in, decision out. Budgets by
// cause (PRODUCT section 4): lost worker 5, unknown (crashed engine) 2, deterministic failure 0.
#pragma once

#include <string>

#include "server/jobs/records.h"

namespace granary::server {

inline constexpr std::uint32_t kLostWorkerBudget = 5;
inline constexpr std::uint32_t kEngineCrashBudget = 2;

enum class ExecutionEnd {
  complete,
  error,
  unstable,
  cancelled,
  timed_out,
  crashed,
  released,
  worker_lost
};

std::string_view outcome_text(ExecutionEnd end);
ExecutionEnd execution_end_of(v1::TaskFinished::Outcome outcome);

// Changes state, counters, error and timed_out of a running job; clears its task and worker. A job
// that goes back to WAITING keeps its submission time, so it is first in line again.
void apply_execution_end(JobRecord& job, ExecutionEnd end, const std::string& message, Now now);

}  // namespace granary::server
