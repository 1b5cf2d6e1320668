#include "server/jobs/retry_policy.h"

#include <gtest/gtest.h>

namespace granary::server {
namespace {

JobRecord running() {
  JobRecord job;
  job.id = 1;
  job.state = v1::RUNNING;
  job.task = 9;
  job.attempts = 1;
  return job;
}

// How many executions end the same way before the job is given up.
std::uint32_t executions_until_final(ExecutionEnd end) {
  JobRecord job = running();
  for (std::uint32_t i = 1; i < 100; ++i) {
    apply_execution_end(job, end, "why", {1000, 1});
    if (job.state != v1::WAITING) return i;
    job.state = v1::RUNNING;
    ++job.attempts;
  }
  return 0;
}

TEST(RetryPolicy, budgets_are_by_cause) {
  EXPECT_EQ(executions_until_final(ExecutionEnd::error), 1u);  // deterministic failure: 0 retries
  EXPECT_EQ(executions_until_final(ExecutionEnd::unstable), 1u);
  EXPECT_EQ(executions_until_final(ExecutionEnd::crashed), 3u);      // unknown: 2
  EXPECT_EQ(executions_until_final(ExecutionEnd::worker_lost), 6u);  // lost worker: 5
  EXPECT_EQ(executions_until_final(ExecutionEnd::released), 0u);     // a drain costs nothing
}

TEST(RetryPolicy, a_requeued_job_keeps_no_execution) {
  JobRecord job = running();
  apply_execution_end(job, ExecutionEnd::worker_lost, "worker a was lost", {1000, 1});
  EXPECT_EQ(job.state, v1::WAITING);
  EXPECT_EQ(job.task, 0);
  EXPECT_EQ(job.ended_ms, 0);
}

TEST(RetryPolicy, a_cancelled_job_is_not_run_again_when_its_worker_dies) {
  JobRecord job = running();
  job.cancel_requested = true;
  apply_execution_end(job, ExecutionEnd::worker_lost, "lost", {1000, 1});
  EXPECT_EQ(job.state, v1::CANCELLED);
}

TEST(RetryPolicy, a_timeout_is_an_error_that_says_so) {
  JobRecord job = running();
  apply_execution_end(job, ExecutionEnd::timed_out, "time limit of 3 s", {1000, 1});
  EXPECT_EQ(job.state, v1::ERROR);
  EXPECT_TRUE(job.timed_out);
}

}  // namespace
}  // namespace granary::server
