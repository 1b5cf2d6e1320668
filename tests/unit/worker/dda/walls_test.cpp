#include "worker/dda/walls.h"

#include <gtest/gtest.h>

namespace granary::dda {
namespace {

Walls chain(std::vector<Vec2> points) {
  Walls walls;
  walls.add_chain(points, false);
  return walls;
}

int claims(const Walls& walls, Vec2 centre) {
  int count = 0;
  for (std::size_t s = 0; s < walls.segments.size(); ++s)
    if (touch_segment(walls.segments, static_cast<std::int32_t>(s), centre, centre, 0.1)) ++count;
  return count;
}

TEST(Walls, touch_points_from_the_disk_into_the_wall_on_either_side) {
  const Walls walls = chain({{0, 0}, {2, 0}});
  const auto above = touch_segment(walls.segments, 0, {1, 0.3}, {1, 0.25}, 0.1);
  ASSERT_TRUE(above);
  EXPECT_DOUBLE_EQ(above->normal.y, -1);
  EXPECT_DOUBLE_EQ(above->gap_start, 0.2);
  EXPECT_DOUBLE_EQ(above->gap_end, 0.15);
  const auto below = touch_segment(walls.segments, 0, {1, -0.3}, {1, -0.3}, 0.1);
  ASSERT_TRUE(below);
  EXPECT_DOUBLE_EQ(below->normal.y, 1);
}

TEST(Walls, prediction_through_the_wall_keeps_the_side) {
  const Walls walls = chain({{0, 0}, {2, 0}});
  const auto touch = touch_segment(walls.segments, 0, {1, 0.1}, {1, -0.5}, 0.1);
  ASSERT_TRUE(touch);
  EXPECT_DOUBLE_EQ(touch->normal.y, -1);
  EXPECT_DOUBLE_EQ(touch->gap_end, -0.6);
}

TEST(Walls, a_joint_is_claimed_once_from_outside_and_by_both_flanks_from_inside) {
  const Walls walls = chain({{-1, 1}, {0, 0}, {1, 1}});
  EXPECT_EQ(claims(walls, {0, 0.3}), 2);    // in the notch: both flanks
  EXPECT_EQ(claims(walls, {0, -0.3}), 1);   // below the vertex: the vertex, once
  EXPECT_EQ(claims(walls, {0.5, 0.3}), 1);  // beside one flank only
}

TEST(Walls, free_ends_are_touched_as_points) {
  const Walls walls = chain({{0, 0}, {1, 0}});
  const auto touch = touch_segment(walls.segments, 0, {1.3, 0.4}, {1.3, 0.4}, 0.1);
  ASSERT_TRUE(touch);
  EXPECT_NEAR(touch->gap_end, 0.4, 1e-15);
  EXPECT_NEAR(touch->normal.x, -0.6, 1e-15);
}

}  // namespace
}  // namespace granary::dda
