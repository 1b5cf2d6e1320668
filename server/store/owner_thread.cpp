#include "server/store/owner_thread.h"

#include <chrono>
#include <exception>

namespace granary::server {
namespace {

// Bounds the latency of the first request of a batch; larger batches gain nothing measurable.
constexpr std::size_t kMaxBatch = 512;
constexpr std::chrono::milliseconds kLongestBatch{4};

}  // namespace

OwnerThread::OwnerThread(TransactionControl& database, Hooks hooks)
    : database_(database), hooks_(std::move(hooks)), thread_([this] { run(); }) {}

OwnerThread::~OwnerThread() {
  stop();
}

void OwnerThread::stop() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable() && thread_.get_id() != std::this_thread::get_id()) thread_.join();
}

void OwnerThread::post(Work work, Reply reply) {
  add(queue_, {std::move(work), std::move(reply)});
}

void OwnerThread::read(Work work, Reply reply) {
  add(reads_, {std::move(work), std::move(reply)});
}

void OwnerThread::add(std::deque<Item>& queue, Item item) {
  {
    std::lock_guard lock(mutex_);
    if (!stopping_) {
      queue.push_back(std::move(item));
      wake_.notify_one();
      return;
    }
  }
  if (item.reply) item.reply(Error{ErrorCode::unavailable, "the server is shutting down", ""});
}

void OwnerThread::run() {
  using Clock = std::chrono::steady_clock;
  auto next_tick = Clock::now();
  for (;;) {
    std::deque<Item> batch, reads;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_until(lock, next_tick,
                       [this] { return stopping_ || !queue_.empty() || !reads_.empty(); });
      if (stopping_ && queue_.empty() && reads_.empty()) return;
      reads.swap(reads_);
      while (!queue_.empty() && batch.size() < kMaxBatch) {
        batch.push_back(std::move(queue_.front()));
        queue_.pop_front();
      }
    }
    run_reads(reads);
    const bool tick = Clock::now() >= next_tick;
    if (batch.empty() && !tick) continue;
    if (tick) next_tick = Clock::now() + std::chrono::milliseconds(hooks_.tick_ms);
    run_batch(std::move(batch), tick);
  }
}

void OwnerThread::run_reads(const std::deque<Item>& reads) {
  for (const Item& item : reads) {
    Status status = Done{};
    try {
      item.work();
    } catch (const std::exception& error) {
      status = Error{ErrorCode::internal, error.what(), ""};
    }
    if (item.reply) item.reply(status);
  }
}

// What a batch had no time for is first in the next one.
void OwnerThread::put_back(std::deque<Item>& batch, std::size_t first) {
  std::lock_guard lock(mutex_);
  while (batch.size() > first) {
    queue_.push_front(std::move(batch.back()));
    batch.pop_back();
  }
}

void OwnerThread::run_batch(std::deque<Item> batch, bool tick) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<Status> outcomes;
  outcomes.reserve(batch.size());
  Status committed = Done{};
  try {
    database_.begin();
    if (tick && hooks_.on_tick) hooks_.on_tick();
    for (const Item& item : batch) {
      outcomes.push_back(run_item(item.work));
      if (std::chrono::steady_clock::now() - start > kLongestBatch) break;
    }
    if (hooks_.before_commit) hooks_.before_commit();
    commit();
  } catch (const std::exception& error) {
    database_.rollback();
    committed = Error{database_.code_of(error),
                      std::string("the server cannot store anything: ") + error.what(), ""};
  }
  const bool ok = committed.ok();
  if (ok) put_back(batch, outcomes.size());
  if (ok && hooks_.after_commit) hooks_.after_commit();
  if (!ok && hooks_.after_failed_commit) hooks_.after_failed_commit();
  for (std::size_t i = 0; i < batch.size(); ++i)
    if (batch[i].reply) batch[i].reply(ok ? outcomes[i] : committed);
}

void OwnerThread::commit() {
  const auto start = std::chrono::steady_clock::now();
  const auto report = [&](bool ok) {
    if (hooks_.on_commit)
      hooks_.on_commit(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), ok);
  };
  try {
    database_.commit();
  } catch (...) {
    report(false);
    throw;
  }
  report(true);
}

Status OwnerThread::run_item(const Work& work) {
  database_.savepoint();
  try {
    work();
    database_.release_savepoint();
    return Done{};
  } catch (const std::exception& error) {
    if (!database_.in_transaction()) throw;  // nothing of this batch is left to commit
    database_.rollback_to_savepoint();
    return Error{ErrorCode::internal, error.what(), ""};
  }
}

}  // namespace granary::server
