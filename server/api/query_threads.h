// A fixed number of threads for queries and a short queue before them.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace granary::server {

class QueryThreads {
 public:
  static constexpr std::size_t kThreads = 2;
  static constexpr std::size_t kMaxWaiting = 32;

  QueryThreads();
  ~QueryThreads();  // waits for what runs

  bool post(std::function<void()> work);  // false: too many wait already

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> waiting_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace granary::server
