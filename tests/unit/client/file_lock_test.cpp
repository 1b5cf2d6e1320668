#include "client/session/file_lock.h"

#include <gtest/gtest.h>

#include <future>

#include "tests/support/program.h"

namespace granary::session {
namespace {

TEST(FileLock, is_held_by_one_at_a_time_and_freed_with_its_owner) {
  const test::ScratchDirectory scratch;
  {
    const auto first = FileLock::take(scratch.file("lock"));
    ASSERT_TRUE(first.ok());
    const auto second = FileLock::take(scratch.file("lock"));
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, ErrorCode::failed_precondition);
  }
  EXPECT_TRUE(FileLock::take(scratch.file("lock")).ok());
}

TEST(FileLock, waits_until_the_owner_lets_go) {
  const test::ScratchDirectory scratch;
  auto first = std::make_unique<Result<FileLock>>(FileLock::take(scratch.file("lock")));
  std::promise<void> started;
  auto waiting = std::async(std::launch::async, [&] {
    started.set_value();
    return FileLock::wait(scratch.file("lock")).ok();
  });
  started.get_future().wait();
  first.reset();
  EXPECT_TRUE(waiting.get());
}

}  // namespace
}  // namespace granary::session
