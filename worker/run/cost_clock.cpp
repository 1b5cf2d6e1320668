#include "worker/run/cost_clock.h"

#include <sys/resource.h>
#include <time.h>

namespace granary::run {
namespace {

double clock_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double wall_now_s() {
  return clock_s(CLOCK_MONOTONIC);
}
double process_cpu_s() {
  return clock_s(CLOCK_PROCESS_CPUTIME_ID);
}

std::uint64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

}  // namespace granary::run
