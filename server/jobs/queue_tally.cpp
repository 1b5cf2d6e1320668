#include "server/jobs/queue_tally.h"

#include <utility>

namespace granary::server {

void QueueTally::load(std::map<std::string, std::uint64_t> waiting_by_owner, std::uint64_t running) {
  by_owner_ = std::move(waiting_by_owner);
  running_ = running;
  waiting_ = 0;
  for (const auto& [owner, count] : by_owner_) waiting_ += count;
}

void QueueTally::job_waits(const std::string& owner) {
  ++by_owner_[owner];
  ++waiting_;
}

void QueueTally::job_waits_no_more(const std::string& owner) {
  const auto found = by_owner_.find(owner);
  if (found != by_owner_.end() && --found->second == 0) by_owner_.erase(found);
  --waiting_;
}

std::uint64_t QueueTally::waiting_of(const std::string& owner) const {
  const auto found = by_owner_.find(owner);
  return found == by_owner_.end() ? 0 : found->second;
}

}  // namespace granary::server
