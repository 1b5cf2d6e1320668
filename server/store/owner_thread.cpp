#include "server/store/owner_thread.h"

#include <chrono>
#include <exception>

namespace granary::server {
namespace {

// Bounds the latency of the first request of a batch; larger batches gain nothing measurable.
constexpr std::size_t kMaxBatch = 512;

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
  {
    std::lock_guard lock(mutex_);
    if (!stopping_) {
      queue_.push_back({std::move(work), std::move(reply)});
      wake_.notify_one();
      return;
    }
  }
  if (reply) reply(Error{ErrorCode::unavailable, "the server is shutting down", ""});
}

void OwnerThread::run() {
  using Clock = std::chrono::steady_clock;
  auto next_tick = Clock::now();
  for (;;) {
    std::deque<Item> batch;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_until(lock, next_tick, [this] { return stopping_ || !queue_.empty(); });
      if (stopping_ && queue_.empty()) return;
      while (!queue_.empty() && batch.size() < kMaxBatch) {
        batch.push_back(std::move(queue_.front()));
        queue_.pop_front();
      }
    }
    const bool tick = Clock::now() >= next_tick;
    if (tick) next_tick = Clock::now() + std::chrono::milliseconds(hooks_.tick_ms);
    run_batch(std::move(batch), tick);
  }
}

void OwnerThread::run_batch(std::deque<Item> batch, bool tick) {
  std::vector<Status> outcomes;
  outcomes.reserve(batch.size());
  Status committed = Done{};
  try {
    database_.begin();
    if (tick && hooks_.on_tick) hooks_.on_tick();
    for (const Item& item : batch) outcomes.push_back(run_item(item.work));
    if (hooks_.before_commit) hooks_.before_commit();
    commit();
  } catch (const std::exception& error) {
    database_.rollback();
    committed = Error{database_.code_of(error),
                      std::string("the server cannot store anything: ") + error.what(), ""};
  }
  const bool ok = committed.ok();
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
