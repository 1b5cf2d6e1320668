#include "server/jobs/retry_policy.h"

#include <array>

namespace granary::server {
namespace {

void finish(JobRecord& job, v1::JobState state, const std::string& message, Now now) {
  job.state = state;
  job.error = message;
  job.ended_ms = now.wall_ms;
}

void requeue_or_fail(JobRecord& job, bool within_budget, const std::string& message, Now now) {
  if (job.cancel_requested) return finish(job, v1::CANCELLED, "cancelled", now);
  if (!within_budget)
    return finish(job, v1::ERROR,
                  message + " (given up after " + std::to_string(job.attempts) + " attempts)", now);
  job.state = v1::WAITING;
  job.error = message;
}

}  // namespace

std::string_view outcome_text(ExecutionEnd end) {
  constexpr std::array<std::string_view, 8> names = {"complete",  "error",      "unstable",
                                                     "cancelled", "timed out",  "crashed",
                                                     "released",  "worker lost"};
  return names.at(static_cast<std::size_t>(end));
}

ExecutionEnd execution_end_of(v1::TaskFinished::Outcome outcome) {
  switch (outcome) {
    case v1::TaskFinished::COMPLETE:
      return ExecutionEnd::complete;
    case v1::TaskFinished::ERROR:
      return ExecutionEnd::error;
    case v1::TaskFinished::UNSTABLE:
      return ExecutionEnd::unstable;
    case v1::TaskFinished::CANCELLED:
      return ExecutionEnd::cancelled;
    case v1::TaskFinished::TIMED_OUT:
      return ExecutionEnd::timed_out;
    case v1::TaskFinished::RELEASED:
      return ExecutionEnd::released;
    default:
      return ExecutionEnd::crashed;
  }
}

void apply_execution_end(JobRecord& job, ExecutionEnd end, const std::string& message, Now now) {
  job.task = 0;
  switch (end) {
    case ExecutionEnd::complete:
      return finish(job, v1::COMPLETE, "", now);
    case ExecutionEnd::error:
      return finish(job, v1::ERROR, message, now);
    case ExecutionEnd::unstable:
      return finish(job, v1::UNSTABLE, message, now);
    case ExecutionEnd::cancelled:
      return finish(job, v1::CANCELLED, message.empty() ? "cancelled" : message, now);
    case ExecutionEnd::timed_out:
      job.timed_out = true;
      return finish(job, v1::ERROR, message, now);
    case ExecutionEnd::crashed:
      ++job.engine_crashes;
      return requeue_or_fail(job, job.engine_crashes <= kEngineCrashBudget, message, now);
    case ExecutionEnd::worker_lost:
      ++job.lost_workers;
      return requeue_or_fail(job, job.lost_workers <= kLostWorkerBudget, message, now);
    case ExecutionEnd::released:
      return requeue_or_fail(job, true, message, now);
  }
}

}  // namespace granary::server
