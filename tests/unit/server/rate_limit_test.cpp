#include "server/jobs/rate_limit.h"

#include <gtest/gtest.h>

namespace granary::server {
namespace {

TEST(RateLimit, a_burst_passes_and_a_flood_waits_for_its_rate) {
  RateLimit limit(10, 100);
  EXPECT_EQ(limit.take("anna", 100, 0), 0);
  EXPECT_EQ(limit.take("anna", 1, 0), 100) << "one job at ten a second";
  EXPECT_EQ(limit.take("anna", 1, 99), 1);
  EXPECT_EQ(limit.take("anna", 1, 100), 0);
}

TEST(RateLimit, owners_do_not_share) {
  RateLimit limit(1, 5);
  EXPECT_EQ(limit.take("anna", 5, 0), 0);
  EXPECT_GT(limit.take("anna", 1, 0), 0);
  EXPECT_EQ(limit.take("ben", 5, 0), 0);
}

TEST(RateLimit, a_refusal_takes_nothing) {
  RateLimit limit(1, 5);
  EXPECT_EQ(limit.take("anna", 3, 0), 0);
  EXPECT_GT(limit.take("anna", 3, 0), 0);
  EXPECT_EQ(limit.take("anna", 2, 0), 0);
}

TEST(RateLimit, a_batch_beyond_the_burst_passes_when_nothing_else_went) {
  RateLimit limit(10, 100);
  EXPECT_EQ(limit.take("anna", 10'000, 0), 0);
  EXPECT_EQ(limit.take("anna", 10'000, 5'000), 5'000);
}

TEST(RateLimit, a_steady_clock_that_stands_still_gives_nothing) {
  RateLimit limit(10, 10);
  EXPECT_EQ(limit.take("anna", 10, 1000), 0);
  EXPECT_GT(limit.take("anna", 1, 900), 0);
}

}  // namespace
}  // namespace granary::server
