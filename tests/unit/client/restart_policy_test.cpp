#include "client/session/restart_policy.h"

#include <gtest/gtest.h>

namespace granary::session {
namespace {

TEST(RestartPolicy, starts_a_child_that_lived_well_again_at_once_every_time) {
  RestartPolicy policy;
  for (int death = 0; death < 5; ++death) EXPECT_EQ(policy.delay_after_s(60), 0);
}

TEST(RestartPolicy, forgives_one_early_death_then_waits_longer_each_time_up_to_a_limit) {
  RestartPolicy policy;
  EXPECT_EQ(policy.delay_after_s(0.1), 0);
  double before_s = 0;
  for (int death = 0; death < 6; ++death) {
    const double delay_s = policy.delay_after_s(0.1);
    EXPECT_GT(delay_s, before_s);
    before_s = delay_s;
  }
  for (int death = 0; death < 50; ++death) policy.delay_after_s(0.1);
  EXPECT_EQ(policy.delay_after_s(0.1), RestartPolicy::kLongestDelay_s);
}

TEST(RestartPolicy, forgets_early_deaths_after_a_good_life) {
  RestartPolicy policy;
  for (int death = 0; death < 5; ++death) policy.delay_after_s(0.1);
  EXPECT_EQ(policy.delay_after_s(RestartPolicy::kYoung_s), 0);
  EXPECT_EQ(policy.delay_after_s(0.1), 0);
}

}  // namespace
}  // namespace granary::session
