#include "server/jobs/queue_tally.h"

#include <utility>

namespace granary::server {
namespace {

template <typename Key>
void take_one(std::map<Key, std::uint64_t>& counts, const Key& key) {
  const auto found = counts.find(key);
  if (found != counts.end() && --found->second == 0) counts.erase(found);
}

}  // namespace

void QueueTally::load(std::map<std::string, std::uint64_t> waiting_by_owner,
                      std::map<QueueClass, std::uint64_t> waiting_by_class, std::uint64_t running) {
  by_owner_ = std::move(waiting_by_owner);
  by_class_ = std::move(waiting_by_class);
  running_ = running;
  waiting_ = 0;
  for (const auto& [owner, count] : by_owner_) waiting_ += count;
}

void QueueTally::job_waits(const std::string& owner, const QueueClass& job_class) {
  ++by_owner_[owner];
  ++by_class_[job_class];
  ++waiting_;
}

void QueueTally::job_waits_no_more(const std::string& owner, const QueueClass& job_class) {
  take_one(by_owner_, owner);
  take_one(by_class_, job_class);
  --waiting_;
}

std::uint64_t QueueTally::waiting_of(const std::string& owner) const {
  const auto found = by_owner_.find(owner);
  return found == by_owner_.end() ? 0 : found->second;
}

}  // namespace granary::server
