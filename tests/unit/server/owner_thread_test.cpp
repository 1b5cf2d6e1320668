#include "server/store/owner_thread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <string>

namespace granary::server {
namespace {

class FakeTransactions : public TransactionControl {
 public:
  void begin() override { log += "b"; }
  void commit() override {
    if (fail_commits) throw std::runtime_error("disk full");
    log += "c";
  }
  void rollback() override { log += "r"; }
  void savepoint() override {}
  void release_savepoint() override { log += "+"; }
  void rollback_to_savepoint() override { log += "-"; }
  bool in_transaction() const override { return !lost_transaction; }
  ErrorCode code_of(const std::exception&) const override {
    return lost_transaction ? ErrorCode::resource_exhausted : ErrorCode::unavailable;
  }

  std::atomic<bool> fail_commits = false;
  std::atomic<bool> lost_transaction = false;
  std::string log;  // owner thread
};

Status ask(OwnerThread& owner, OwnerThread::Work work) {
  std::promise<Status> answer;
  owner.post(std::move(work), [&](const Status& status) { answer.set_value(status); });
  return answer.get_future().get();
}

// The thread in the middle of a request, so that what is posted now waits.
class Held {
 public:
  explicit Held(OwnerThread& owner) {
    owner.post(
        [this] {
          runs_.set_value();
          free_.get_future().wait();
        },
        nullptr);
    runs_.get_future().wait();
  }
  void let_go() { free_.set_value(); }

 private:
  std::promise<void> runs_, free_;
};

TEST(OwnerThread, replies_after_the_commit) {
  FakeTransactions database;
  OwnerThread owner(database, {});
  std::string at_reply;
  std::promise<void> done;
  owner.post([] {},
             [&](const Status&) {
               at_reply = database.log;
               done.set_value();
             });
  done.get_future().wait();
  EXPECT_EQ(at_reply.back(), 'c');
}

TEST(OwnerThread, a_read_goes_before_waiting_writes_and_needs_no_transaction) {
  FakeTransactions database;
  std::atomic<int> written = 0;  // outlives the thread, which ends with its last write
  OwnerThread owner(database, {});
  Held held(owner);
  for (int k = 0; k < 20; ++k) owner.post([&] { ++written; }, nullptr);
  std::promise<std::pair<int, std::string>> seen;
  owner.read([&] { seen.set_value({written, database.log}); }, nullptr);
  held.let_go();
  const auto [written_before, log] = seen.get_future().get();
  EXPECT_EQ(written_before, 0);
  EXPECT_EQ(log.back(), 'c') << "outside of a transaction, after the commit of what was running";
}

TEST(OwnerThread, a_long_batch_is_committed_in_pieces_in_order) {
  FakeTransactions database;
  OwnerThread owner(database, {});
  Held held(owner);
  std::vector<int> order;
  for (int k = 0; k < 6; ++k)
    owner.post(
        [&order, k] {
          order.push_back(k);
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        },
        nullptr);
  held.let_go();
  owner.stop();
  EXPECT_EQ(order, (std::vector{0, 1, 2, 3, 4, 5}));
  EXPECT_GE(std::count(database.log.begin(), database.log.end(), 'c'), 6);
}

TEST(OwnerThread, a_throwing_request_is_undone_alone) {
  FakeTransactions database;
  OwnerThread owner(database, {});
  EXPECT_EQ(ask(owner, [] { throw std::runtime_error("constraint"); }).error().code,
            ErrorCode::internal);
  EXPECT_TRUE(ask(owner, [] {}).ok());
  owner.stop();
  EXPECT_NE(database.log.find('-'), std::string::npos);
  EXPECT_NE(database.log.find('+'), std::string::npos);
}

// What SQLite does when the disk fills up in the middle of a statement.
TEST(OwnerThread, a_transaction_given_up_by_the_database_fails_its_whole_batch) {
  FakeTransactions database;
  int effects = 0;
  OwnerThread::Hooks hooks;
  hooks.after_commit = [&] { ++effects; };
  OwnerThread owner(database, hooks);
  const Status status = ask(owner, [&] {
    database.lost_transaction = true;
    throw std::runtime_error("database or disk is full");
  });
  EXPECT_EQ(status.error().code, ErrorCode::resource_exhausted);
  EXPECT_NE(status.error().message.find("database or disk is full"), std::string::npos);
  owner.stop();
  EXPECT_EQ(database.log.find('-'), std::string::npos) << "a savepoint that is gone was rolled back to";
}

TEST(OwnerThread, a_failed_commit_fails_every_request_and_drops_effects) {
  FakeTransactions database;
  int effects = 0, rebuilds = 0;
  OwnerThread::Hooks hooks;
  hooks.after_commit = [&] { ++effects; };
  hooks.after_failed_commit = [&] { ++rebuilds; };
  hooks.tick_ms = 1'000'000;
  OwnerThread owner(database, hooks);
  ASSERT_TRUE(ask(owner, [] {}).ok());
  const int before = effects;
  database.fail_commits = true;
  EXPECT_EQ(ask(owner, [] {}).error().code, ErrorCode::unavailable);
  EXPECT_EQ(effects, before);
  EXPECT_GE(rebuilds, 1);
  database.fail_commits = false;
  EXPECT_TRUE(ask(owner, [] {}).ok());
}

TEST(OwnerThread, answers_unavailable_after_stop_and_finishes_what_was_posted) {
  FakeTransactions database;
  OwnerThread owner(database, {});
  int ran = 0;
  for (int i = 0; i < 100; ++i) owner.post([&] { ++ran; }, nullptr);
  owner.stop();
  EXPECT_EQ(ran, 100);
  EXPECT_EQ(ask(owner, [&] { ++ran; }).error().code, ErrorCode::unavailable);
  EXPECT_EQ(ran, 100);
}

}  // namespace
}  // namespace granary::server
