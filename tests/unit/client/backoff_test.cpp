#include "client/session/backoff.h"

#include <gtest/gtest.h>

#include <vector>

namespace granary::session {
namespace {

std::vector<double> delays(Backoff& backoff, double jitter) {
  std::vector<double> all;
  while (const auto delay_s = backoff.next_delay_s(jitter)) all.push_back(*delay_s);
  return all;
}

TEST(Backoff, doubles_to_its_longest_and_ends_with_patience) {
  Backoff backoff({.first_s = 1, .longest_s = 4, .patience_s = 10});
  EXPECT_EQ(delays(backoff, 0), (std::vector<double>{1, 2, 4, 4}));  // 11 s handed out
}

TEST(Backoff, jitter_shortens_by_at_most_half) {
  Backoff backoff({.first_s = 1, .longest_s = 1, .patience_s = 1.4});
  EXPECT_EQ(delays(backoff, 0.999).size(), 3u);
  backoff.reset();
  EXPECT_GE(*backoff.next_delay_s(0.999), 0.5);
}

TEST(Backoff, leaves_a_refusing_server_alone_as_long_as_it_asks_and_counts_that_as_patience) {
  Backoff backoff({.first_s = 0.1, .longest_s = 2, .patience_s = 10});
  int tries = 0;
  while (const auto delay_s = backoff.next_delay_s(0.2, 4)) {
    EXPECT_DOUBLE_EQ(*delay_s, 4.4);
    ++tries;
  }
  EXPECT_EQ(tries, 3);  // 13.2 s handed out
}

TEST(Backoff, starts_over_after_a_success) {
  Backoff backoff({.first_s = 1, .longest_s = 8, .patience_s = 3});
  delays(backoff, 0);
  backoff.reset();
  EXPECT_EQ(backoff.next_delay_s(0), 1);
}

}  // namespace
}  // namespace granary::session
