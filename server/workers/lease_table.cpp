#include "server/workers/lease_table.h"

#include <algorithm>

namespace granary::server {

void LeaseTable::grant(std::int64_t task, std::int64_t job, const std::string& worker,
                       std::int64_t now_ms) {
  end(task);
  leases_[task] = {task, job, worker, now_ms + kLeaseMs};
  ++per_worker_[worker];
}

void LeaseTable::end(std::int64_t task) {
  const auto found = leases_.find(task);
  if (found == leases_.end()) return;
  const auto count = per_worker_.find(found->second.worker);
  if (--count->second == 0) per_worker_.erase(count);
  leases_.erase(found);
}

void LeaseTable::clear() {
  leases_.clear();
  per_worker_.clear();
}

std::uint32_t LeaseTable::count_of(const std::string& worker) const {
  const auto found = per_worker_.find(worker);
  return found == per_worker_.end() ? 0 : found->second;
}

bool LeaseTable::renew(std::int64_t task, const std::string& worker, std::int64_t now_ms) {
  const auto found = leases_.find(task);
  if (found == leases_.end() || found->second.worker != worker) return false;
  found->second.expires_ms = now_ms + kLeaseMs;
  return true;
}

void LeaseTable::shorten(const std::string& worker, std::int64_t now_ms) {
  for (auto& [task, lease] : leases_)
    if (lease.worker == worker)
      lease.expires_ms = std::min(lease.expires_ms, now_ms + kReconnectMs);
}

const Lease* LeaseTable::find(std::int64_t task) const {
  const auto found = leases_.find(task);
  return found == leases_.end() ? nullptr : &found->second;
}

std::vector<Lease> LeaseTable::of_worker(const std::string& worker) const {
  std::vector<Lease> out;
  for (const auto& [task, lease] : leases_)
    if (lease.worker == worker) out.push_back(lease);
  return out;
}

std::vector<Lease> LeaseTable::expired(std::int64_t now_ms) const {
  std::vector<Lease> out;
  for (const auto& [task, lease] : leases_)
    if (lease.expires_ms <= now_ms) out.push_back(lease);
  std::sort(out.begin(), out.end(), [](const Lease& a, const Lease& b) { return a.task < b.task; });
  return out;
}

}  // namespace granary::server
