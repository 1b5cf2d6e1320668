// When a dead child process is started again: at once, unless it keeps dying young, then after
// delays that double. Pure: times are arguments.
#pragma once

#include <algorithm>

namespace granary::session {

class RestartPolicy {
 public:
  static constexpr double kYoung_s = 5;  // a life shorter than this counts as a failed start
  static constexpr double kFirstDelay_s = 0.25;
  static constexpr double kLongestDelay_s = 30;

  // Seconds to wait before the next start of a child that lived `lived_s`. The first early death is
  // forgiven: a worker killed right after its start comes back at once.
  double delay_after_s(double lived_s) {
    early_deaths_ = lived_s < kYoung_s ? early_deaths_ + 1 : 0;
    if (early_deaths_ < 2) return 0;
    const int doublings = std::min(early_deaths_ - 2, 10);
    return std::min(kFirstDelay_s * static_cast<double>(1 << doublings), kLongestDelay_s);
  }

 private:
  int early_deaths_ = 0;
};

}  // namespace granary::session
