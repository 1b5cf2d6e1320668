#include "worker/measure/discharge_values.h"

#include <gtest/gtest.h>

namespace granary::measure {
namespace {

TEST(DischargeValues, centre_is_weighted_by_mass_and_spread_counts_disks) {
  // Nine disks at x = 1 and one heavy at x = 11: centre 6, eight of ten lie within 5 of it.
  std::vector<FlyingDisk> flying(9, {1, 0, 1});
  flying.push_back({11, 0, 9});
  const auto values = flight_values(flying, 10);
  ASSERT_TRUE(values);
  EXPECT_DOUBLE_EQ(values->centre_x, 6);
  EXPECT_DOUBLE_EQ(values->distance, 6);
  EXPECT_DOUBLE_EQ(values->spread, 5);
}

TEST(DischargeValues, spread_holds_eighty_percent_rounded_up) {
  std::vector<FlyingDisk> flying;
  for (int k = -3; k <= 3; ++k) flying.push_back({2.0 + k, 0, 1});  // ceil(0.8 * 7) = 6
  EXPECT_DOUBLE_EQ(flight_values(flying, 7)->spread, 3);
  flying.push_back({2, 1, 1});
  flying.push_back({2, -1, 1});
  flying.push_back({2, 0, 1});  // 8 of 10: all but the two at distance 3
  EXPECT_DOUBLE_EQ(flight_values(flying, 10)->spread, 2);
}

TEST(DischargeValues, are_none_when_fewer_than_five_percent_fly) {
  const std::vector<FlyingDisk> four(4, {1, 1, 1});
  EXPECT_FALSE(flight_values(four, 100));
  EXPECT_TRUE(flight_values(four, 80));
  EXPECT_FALSE(landing_values({}, 10));
}

TEST(DischargeValues, angle_of_a_share_is_interpolated) {
  const std::vector<double> angle = {0, 10, 20, 30}, remaining = {100, 100, 60, 0};
  EXPECT_DOUBLE_EQ(*angle_of_share_left(angle, remaining, 0.5), 20 + 10 * 10.0 / 60);
  EXPECT_DOUBLE_EQ(*angle_of_share_left(angle, remaining, 0.05), 11.25);
  EXPECT_FALSE(angle_of_share_left(angle, std::vector<double>{100, 90, 80, 70}, 0.5));
}

}  // namespace
}  // namespace granary::measure
