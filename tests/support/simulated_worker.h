// A worker that speaks the real protocol and computes nothing: every task is complete at once, with one
// small shared file as its result. For measuring and stressing the queue.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace granary::test {

class SimulatedWorker {
 public:
  // Connects to `address` and works until stop(). `finish` false: takes tasks and never ends them.
  SimulatedWorker(const std::string& address, const std::string& id, unsigned slots, bool finish = true);
  ~SimulatedWorker();
  void stop();

  std::uint64_t tasks_done() const;
  // From telling a result to holding the next task, milliseconds, in order of arrival. After stop().
  std::vector<double> lease_ms() const;
  // Names of jobs in order of assignment. After stop().
  std::vector<std::string> jobs() const;

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace granary::test
