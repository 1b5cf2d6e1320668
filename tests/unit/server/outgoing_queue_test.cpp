#include "server/api/outgoing_queue.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace granary::server {
namespace {

struct FakeReactor {
  std::vector<std::string> written;
  std::vector<grpc::StatusCode> finished;
  OutgoingQueue<std::string> queue{
      {[this](const std::string* message) { written.push_back(*message); },
       [this](grpc::Status status) { finished.push_back(status.error_code()); }}};
};

TEST(OutgoingQueue, has_one_write_in_flight) {
  FakeReactor reactor;
  reactor.queue.push("a");
  reactor.queue.push("b");
  EXPECT_EQ(reactor.written, std::vector<std::string>{"a"});
  reactor.queue.on_write_done(true);
  EXPECT_EQ(reactor.written, (std::vector<std::string>{"a", "b"}));
}

TEST(OutgoingQueue, finishes_once_and_only_after_what_is_queued) {
  FakeReactor reactor;
  reactor.queue.push("a");
  reactor.queue.push("b");
  reactor.queue.finish(grpc::Status::OK);
  reactor.queue.push("too late");
  EXPECT_TRUE(reactor.finished.empty());
  reactor.queue.on_write_done(true);
  EXPECT_TRUE(reactor.finished.empty());
  reactor.queue.on_write_done(true);
  reactor.queue.finish(grpc::Status::CANCELLED);
  EXPECT_EQ(reactor.finished, std::vector<grpc::StatusCode>{grpc::StatusCode::OK});
  EXPECT_EQ(reactor.written.size(), 2u);
}

TEST(OutgoingQueue, a_broken_stream_finishes_without_further_writes) {
  FakeReactor reactor;
  reactor.queue.push("a");
  reactor.queue.push("b");
  reactor.queue.on_write_done(false);
  EXPECT_EQ(reactor.written.size(), 1u);
  EXPECT_EQ(reactor.finished.size(), 1u);
}

TEST(OutgoingQueue, replaces_unsent_progress_for_a_slow_reader) {
  FakeReactor reactor;
  const auto is_progress = [](const std::string& message) { return message[0] == 'p'; };
  reactor.queue.push("state");
  for (int i = 0; i < 1000; ++i) reactor.queue.push("p" + std::to_string(i), is_progress);
  reactor.queue.push("end");
  for (int i = 0; i < 3; ++i) reactor.queue.on_write_done(true);
  EXPECT_EQ(reactor.written, (std::vector<std::string>{"state", "p999", "end"}));
}

}  // namespace
}  // namespace granary::server
