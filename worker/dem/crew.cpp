#include "worker/dem/crew.h"

namespace granary::dem {
namespace {

constexpr int kPolls = 64;    // of a value that is about to change
constexpr int kYields = 256;  // before a helper goes to sleep: about the time between two tasks

template <typename Ready>
bool poll(Ready ready, int yields) {
  for (int k = 0; k < kPolls; ++k) {
    if (ready()) return true;
  }
  for (int k = 0; k < yields; ++k) {
    if (ready()) return true;
    std::this_thread::yield();
  }
  return false;
}

}  // namespace

void Milestone::wait_for(std::uint64_t target) const {
  while (!poll([&] { return reached_.load(std::memory_order_acquire) >= target; }, kYields)) {
  }
}

Crew::Crew(unsigned threads) {
  for (unsigned k = 1; k < threads; ++k) helpers_.emplace_back([this, k] { help(k); });
}

Crew::~Crew() {
  closing_.store(true);
  round_.fetch_add(1);
  round_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void Crew::run(const std::function<void(unsigned)>& task) {
  if (helpers_.empty()) return task(0);
  task_ = &task;
  busy_.store(size() - 1);
  round_.fetch_add(1);
  round_.notify_all();
  task(0);
  const auto done = [this] { return busy_.load(std::memory_order_acquire) == 0; };
  while (!poll(done, kYields)) {
  }
}

void Crew::help(unsigned index) {
  std::uint64_t seen = 0;
  for (;;) {
    if (!poll([&] { return round_.load() != seen; }, kYields)) round_.wait(seen);
    seen = round_.load();
    if (closing_.load()) return;
    (*task_)(index);
    busy_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace granary::dem
