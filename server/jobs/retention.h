// Old jobs leave by themselves (granaryd --keep-days): with their values, series and, by the sweep
// that follows, their files. Never a job that waits or runs, one of a study that still goes on, or
// one with the tag `keep`. A bounded piece of work per call, on the owner thread.
#pragma once

#include "server/jobs/dispatcher.h"

namespace granary::server {

class Retention {
 public:
  // keep_days = 0: everything is kept.
  Retention(JobStore& store, Dispatcher& dispatcher, std::uint32_t keep_days);

  // Removes some of what ended more than keep_days ago; the number of jobs removed.
  std::size_t work(Now now);

 private:
  void end_pass(Now now);

  JobStore& store_;
  Dispatcher& dispatcher_;
  std::int64_t keep_ms_;
  JobId seen_ = 0;  // of this pass: jobs are looked at in the order of their submission
  std::int64_t next_pass_ms_ = 0;  // steady
};

}  // namespace granary::server
