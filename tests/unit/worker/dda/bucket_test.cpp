#include "worker/dda/bucket.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace granary::dda {
namespace {

TEST(Bucket, straight_wall_encloses_a_triangle) {
  const BucketGeometry bucket = make_bucket(straight_wall({-0.4, 0.4}), {.height = 0.4}, 0.5);
  EXPECT_NEAR(bucket.area(), 0.08, 1e-15);
  EXPECT_TRUE(bucket.contains({-0.6, 0.2}));
  EXPECT_FALSE(bucket.contains({-0.8, 0.2}));
  EXPECT_FALSE(bucket.contains({-0.6, 0.41}));
  EXPECT_FALSE(bucket.contains({-0.49, 0.2}));
}

TEST(Bucket, deflector_continues_the_inner_wall_and_turns_outwards) {
  const InnerWall inner{.height = 0.3, .deflector = 0.1, .deflector_angle = std::numbers::pi / 4};
  const BucketGeometry bucket = make_bucket(straight_wall({-0.4, 0.4}), inner, 0.5);
  ASSERT_EQ(bucket.inner_wall.size(), 3u);
  EXPECT_NEAR(bucket.inner_wall[2].x, -0.5 - 0.1 * std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(bucket.inner_wall[2].y, 0.3 + 0.1 * std::sqrt(0.5), 1e-15);
}

TEST(Bucket, bezier_wall_with_collinear_control_points_is_straight) {
  for (const Vec2 point : bezier_wall({-0.1, -0.2, -0.3}, {-0.4, 0.4}))
    EXPECT_NEAR(point.x, -point.y, 1e-15);
}

TEST(Bucket, bezier_wall_passes_through_the_value_of_eq_11_at_one_half) {
  const auto wall = bezier_wall({-0.3, -0.4, -0.45}, {-0.4, 0.4});
  const Vec2 middle = wall[wall.size() / 2];
  EXPECT_NEAR(middle.x, (4 * -0.3 + 6 * -0.4 + 4 * -0.45 - 0.4) / 16, 1e-15);
  EXPECT_NEAR(middle.y, (4 * 0.1 + 6 * 0.2 + 4 * 0.3 + 0.4) / 16, 1e-15);
}

TEST(Bucket, logarithmic_wall_keeps_its_angle_to_the_radius) {
  const auto wall = logarithmic_wall({-0.4, 0.4}, 0.5);
  EXPECT_NEAR(wall.back().x, -0.4, 1e-12);
  EXPECT_NEAR(wall.back().y, 0.4, 1e-12);
  const Vec2 centre{0.5, 0};  // pulley centre seen from the foot
  const auto angle = [&](std::size_t k) {
    const Vec2 along = wall[k + 1] - wall[k], radius = 0.5 * (wall[k] + wall[k + 1]) - centre;
    return std::atan2(cross(radius, along), dot(radius, along));
  };
  for (std::size_t k = 0; k + 1 < wall.size(); ++k) EXPECT_NEAR(angle(k), angle(0), 1e-9);
}

}  // namespace
}  // namespace granary::dda
