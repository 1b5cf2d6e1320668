// The one thread that owns the database and all policy state. Requests are posted as closures; the
// thread takes everything that has piled up, runs it in one transaction, commits once (one fsync
// for many requests), and only then lets the replies and effects out. A closure that throws is
// undone alone (savepoint); a failed commit fails every request of its batch. Reads go first.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "proto/contract/result.h"

namespace granary::server {

// What the thread needs of the database; implemented by Database, faked in tests.
class TransactionControl {
 public:
  virtual ~TransactionControl() = default;
  virtual void begin() = 0;
  virtual void commit() = 0;  // throws std::exception; the transaction is then rolled back
  virtual void rollback() = 0;
  virtual void savepoint() = 0;
  virtual void release_savepoint() = 0;
  virtual void rollback_to_savepoint() = 0;
  // SQLite gives up a whole transaction by itself when the disk is full.
  virtual bool in_transaction() const = 0;
  // RESOURCE_EXHAUSTED for a full disk, else UNAVAILABLE.
  virtual ErrorCode code_of(const std::exception& failure) const = 0;
};

class OwnerThread {
 public:
  using Work = std::function<void()>;
  using Reply = std::function<void(const Status&)>;  // after commit; must not block

  struct Hooks {
    std::function<void()> before_commit;        // follow-up work of the whole batch, same transaction
    std::function<void()> after_commit;         // send effects
    std::function<void()> after_failed_commit;  // rebuild memory from the database
    std::function<void()> on_tick;              // inside a transaction, every `tick_ms`
    std::function<void(double seconds, bool ok)> on_commit;  // how long the batch's commit took
    int tick_ms = 500;
  };

  OwnerThread(TransactionControl& database, Hooks hooks);
  ~OwnerThread();  // finishes what was posted

  // From any thread. After stop() the reply comes at once with UNAVAILABLE.
  void post(Work work, Reply reply);
  // Work that changes nothing: done before what waits, outside of any transaction, on what is
  // committed. Thousands of writes that wait do not hold up one look.
  void read(Work work, Reply reply);
  void stop();

 private:
  struct Item {
    Work work;
    Reply reply;
  };
  void add(std::deque<Item>& queue, Item item);
  void run();
  void run_reads(const std::deque<Item>& reads);
  void run_batch(std::deque<Item> batch, bool tick);
  void put_back(std::deque<Item>& batch, std::size_t first);
  void commit();
  Status run_item(const Work& work);

  TransactionControl& database_;
  Hooks hooks_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Item> queue_, reads_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace granary::server
