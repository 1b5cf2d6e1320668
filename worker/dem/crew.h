// The threads of one engine. They share tasks by number, so that who does what never depends on
// luck, and give the processor away while they wait: on a busy machine a spinning wait costs 5-15x.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace granary::dem {

// Counts steps; one thread raises it, others wait until it has reached a number.
class alignas(64) Milestone {
 public:
  void reset() { reached_.store(0, std::memory_order_relaxed); }
  void raise() { reached_.fetch_add(1, std::memory_order_release); }
  void wait_for(std::uint64_t target) const;

 private:
  std::atomic<std::uint64_t> reached_{0};
};

class Crew {
 public:
  explicit Crew(unsigned threads);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  unsigned size() const { return static_cast<unsigned>(helpers_.size()) + 1; }

  // Calls task(0) here and task(1) .. task(size - 1) on the helpers; returns when all are done.
  // Precondition: task does not throw.
  void run(const std::function<void(unsigned)>& task);

 private:
  void help(unsigned index);

  std::vector<std::thread> helpers_;
  const std::function<void(unsigned)>* task_ = nullptr;
  std::atomic<std::uint64_t> round_{0};  // raised to start a task
  std::atomic<unsigned> busy_{0};
  std::atomic<bool> closing_{false};
};

}  // namespace granary::dem
