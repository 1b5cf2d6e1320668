// Delays between tries after a lost connection: doubling with jitter, so that a hundred clients do
// not come back to a restarted server in one instant. Pure: the caller waits and says how long it
// waited.
#pragma once

#include <algorithm>
#include <optional>

namespace granary::session {

struct BackoffLimits {
  double first_s = 0.1;
  double longest_s = 2;
  double patience_s = 10;  // no further try once this much waiting has been handed out
};

class Backoff {
 public:
  explicit Backoff(BackoffLimits limits) : limits_(limits), next_s_(limits.first_s) {}

  // The next delay; nothing when patience is used up. `jitter` in [0, 1) shortens it by up to half.
  // `asked_s`: what a refusing server wants to be left alone for; lengthened by up to half.
  std::optional<double> next_delay_s(double jitter, std::optional<double> asked_s = {}) {
    if (spent_s_ >= limits_.patience_s) return std::nullopt;
    const double delay_s = asked_s ? *asked_s * (1 + 0.5 * jitter) : next_s_ * (1 - 0.5 * jitter);
    spent_s_ += delay_s;
    next_s_ = std::min(next_s_ * 2, limits_.longest_s);
    return delay_s;
  }

  // Something arrived: the connection is good again.
  void reset() { *this = Backoff(limits_); }

 private:
  BackoffLimits limits_;
  double next_s_;
  double spent_s_ = 0;
};

}  // namespace granary::session
