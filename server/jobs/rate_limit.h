// Token buckets by owner: one user's burst passes, one user's flood leaves the others their server. Any
// thread; the clock is an argument.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace granary::server {

class RateLimit {
 public:
  RateLimit(double per_s, double burst) : per_s_(per_s), burst_(burst) {}

  // 0: `cost` was taken. Else nothing was, and the milliseconds until it could be. A cost beyond the whole
  // burst passes when the bucket is full.
  int take(const std::string& owner, double cost, std::int64_t steady_ms);

 private:
  struct Bucket {
    double tokens = 0;
    std::int64_t filled_ms = 0;
  };
  double per_s_, burst_;
  std::mutex mutex_;
  std::map<std::string, Bucket> buckets_;
};

}  // namespace granary::server
