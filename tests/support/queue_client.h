// Direct calls of the Jobs service, many at once, for tests and benchmarks of the queue.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace granary::test {

class QueueClient {
 public:
  explicit QueueClient(const std::string& address);
  ~QueueClient();

  // `count` different small jobs from `first` on, in one call. Throws std::runtime_error when refused.
  std::vector<std::string> submit(std::uint64_t first, std::uint64_t count);
  std::size_t list(std::uint32_t page_size);         // length of the first page
  std::uint64_t count_all(std::uint32_t page_size);  // walks all pages
  void get(const std::string& job);

 private:
  struct Stubs;
  std::unique_ptr<Stubs> stubs_;
};

// Watches one job; a stuck one opens the stream and never reads.
class QueueWatcher {
 public:
  QueueWatcher(const std::string& address, const std::string& job, bool stuck);
  ~QueueWatcher();
  std::uint64_t events() const;

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace granary::test
