// Clocks of a task's price: wall time, CPU time of the whole process, peak memory.
#pragma once

#include <cstdint>

namespace granary::run {

double wall_now_s();             // monotonic
double process_cpu_s();          // user + system of every thread, since the process started
std::uint64_t peak_rss_bytes();  // of the process so far

// Seconds between construction and now.
class CostTimer {
 public:
  CostTimer() : wall_start_s_(wall_now_s()), cpu_start_s_(process_cpu_s()) {}
  double wall_s() const { return wall_now_s() - wall_start_s_; }
  double cpu_s() const { return process_cpu_s() - cpu_start_s_; }

 private:
  double wall_start_s_;
  double cpu_start_s_;
};

// Adds the CPU seconds of its lifetime to a sum.
class AddedCpuTime {
 public:
  explicit AddedCpuTime(double& sum_s) : sum_s_(sum_s) {}
  AddedCpuTime(const AddedCpuTime&) = delete;
  AddedCpuTime& operator=(const AddedCpuTime&) = delete;
  ~AddedCpuTime() { sum_s_ += timer_.cpu_s(); }

 private:
  double& sum_s_;
  CostTimer timer_;
};

}  // namespace granary::run
