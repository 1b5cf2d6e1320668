#include "worker/dda/filling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace granary::dda {
namespace {

void expect_apart(const Disks& disks, double tolerance) {
  for (std::size_t i = 0; i < disks.count(); ++i)
    for (std::size_t j = i + 1; j < disks.count(); ++j) {
      const DiskPose &a = disks.pose[i], &b = disks.pose[j];
      EXPECT_GT(std::hypot(a.x - b.x, a.y - b.y), a.radius + b.radius - tolerance);
    }
}

TEST(Filling, dropped_array_starts_clear_of_the_walls_and_without_overlap) {
  const BucketGeometry bucket = make_bucket(straight_wall({-0.15, 0.15}), {.height = 0.15}, 0.5);
  const Disks disks = drop_array({700, 0.0035, 0.0045, 730, 1}, bucket);
  ASSERT_EQ(disks.count(), 700u);
  expect_apart(disks, 0);
  for (std::size_t k = 0; k < disks.count(); ++k) {
    const DiskPose& p = disks.pose[k];
    EXPECT_LT(p.x + p.radius, -0.5);
    EXPECT_GT(p.x - p.radius, -0.65);
    EXPECT_GT((p.x + 0.5 + p.y) / std::sqrt(2.0), p.radius);  // distance from the outer wall
    EXPECT_GE(2 * p.radius, 0.0035);
    EXPECT_LE(2 * p.radius, 0.0045);
  }
}

TEST(Filling, dropped_array_rests_on_the_bucket_s_own_shape) {
  const BucketGeometry bucket = make_bucket(straight_wall({-0.4, 0.4}), {.height = 0.4}, 0.5);
  const Disks disks = drop_array({4000, 0.003, 0.003, 2200, 1}, bucket);
  double lowest = 1, highest = 0;
  for (std::size_t k = 0; k < disks.count(); ++k) {
    lowest = std::min(lowest, disks.pose[k].y);
    highest = std::max(highest, disks.pose[k].y);
  }
  EXPECT_LT(lowest, 0.01);
  // A level lattice of pitch 1.05 d in the 45 deg wedge: height sqrt(2 N) pitch, and the strips of
  // half a pitch that the slanting and the straight wall cost.
  EXPECT_NEAR(highest, std::sqrt(2 * 4000.0) * 1.05 * 0.003, 4 * 0.003);
}

TEST(Filling, seeds_differ_and_repeat) {
  const BucketGeometry bucket = make_bucket(straight_wall({-0.15, 0.15}), {.height = 0.15}, 0.5);
  const Disks one = drop_array({50, 0.003, 0.004, 730, 1}, bucket);
  const Disks same = drop_array({50, 0.003, 0.004, 730, 1}, bucket);
  const Disks other = drop_array({50, 0.003, 0.004, 730, 2}, bucket);
  EXPECT_EQ(one.pose[7].x, same.pose[7].x);
  EXPECT_NE(one.pose[7].x, other.pose[7].x);
}

TEST(Filling, compact_order_lies_inside_the_bucket) {
  const BucketGeometry bucket = make_bucket(straight_wall({-0.15, 0.15}), {.height = 0.15}, 0.5);
  const Disks disks = compact_order({400, 0.003, 0.003, 730, 1}, bucket);
  ASSERT_EQ(disks.count(), 400u);
  expect_apart(disks, 1e-12);
  for (std::size_t k = 0; k < disks.count(); ++k)
    EXPECT_TRUE(bucket.contains({disks.pose[k].x, disks.pose[k].y}));
}

}  // namespace
}  // namespace granary::dda
