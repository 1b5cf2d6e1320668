#include "server/jobs/rate_limit.h"

#include <algorithm>
#include <cmath>

namespace granary::server {

int RateLimit::take(const std::string& owner, double cost, std::int64_t steady_ms) {
  std::lock_guard lock(mutex_);
  auto [entry, is_new] = buckets_.try_emplace(owner, Bucket{burst_, steady_ms});
  Bucket& bucket = entry->second;
  const double elapsed_s = static_cast<double>(steady_ms - bucket.filled_ms) / 1000;
  bucket.tokens = std::min(burst_, bucket.tokens + per_s_ * std::max(0.0, elapsed_s));
  bucket.filled_ms = steady_ms;
  const double wanted = std::min(cost, burst_);
  if (bucket.tokens < wanted)
    return static_cast<int>(std::ceil(1000 * (wanted - bucket.tokens) / per_s_ - 1e-6));
  bucket.tokens -= wanted;
  return 0;
}

}  // namespace granary::server
