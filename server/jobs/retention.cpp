#include "server/jobs/retention.h"

namespace granary::server {
namespace {

constexpr std::int64_t kDayMs = 86'400'000;
constexpr std::int64_t kPassIntervalMs = 3'600'000;
constexpr std::uint32_t kJobsPerCall = 500;

}  // namespace

Retention::Retention(JobStore& store, Dispatcher& dispatcher, std::uint32_t keep_days)
    : store_(store), dispatcher_(dispatcher), keep_ms_(keep_days * kDayMs) {}

std::size_t Retention::work(Now now) {
  if (keep_ms_ == 0 || now.steady_ms < next_pass_ms_) return 0;
  const std::int64_t ended_before_ms = now.wall_ms - keep_ms_;
  const std::vector<JobAge> jobs = store_.ages_after(seen_, kJobsPerCall);
  std::size_t removed = 0;
  for (const JobAge& job : jobs) {
    if (job.submitted_ms > ended_before_ms) break;  // and so are all behind it
    seen_ = job.id;
    if (job.removable && job.ended_ms <= ended_before_ms && dispatcher_.remove(job.id).ok())
      ++removed;
  }
  if (jobs.size() < kJobsPerCall || jobs.back().id != seen_) end_pass(now);
  return removed;
}

void Retention::end_pass(Now now) {
  store_.forget_before(now.wall_ms - keep_ms_);
  seen_ = 0;
  next_pass_ms_ = now.steady_ms + kPassIntervalMs;
}

}  // namespace granary::server
