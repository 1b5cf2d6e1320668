#include "worker/dda/belt_drive.h"

#include <gtest/gtest.h>

namespace granary::dda {
namespace {

constexpr BeltDrive kDrive{.rotation_rate = 8.9, .pulley_radius = 0.5};

TEST(BeltDrive, turns_clockwise_over_the_top) {
  const Vec2 foot{-0.5, 0};
  const Vec2 top = kDrive.pose_at(kDrive.half_turn_time() / 2).to_world(foot);
  EXPECT_NEAR(top.x, 0, 1e-15);
  EXPECT_NEAR(top.y, 0.5, 1e-15);
  const Vec2 down = kDrive.pose_at(kDrive.half_turn_time()).to_world(foot);
  EXPECT_NEAR(down.x, 0.5, 1e-15);
  EXPECT_NEAR(down.y, 0, 1e-15);
}

TEST(BeltDrive, keeps_distances_whatever_the_angle) {
  const Vec2 a{-0.5, 0}, b{-0.9, 0.4};
  for (double t = -0.1; t < 0.6; t += 0.013) {
    const RigidPose pose = kDrive.pose_at(t);
    EXPECT_NEAR(length(pose.to_world(a) - pose.to_world(b)), length(a - b), 1e-15);
  }
}

TEST(BeltDrive, velocity_is_the_derivative_of_the_position_in_every_phase) {
  const Vec2 body{-0.7, 0.3};
  const double h = 1e-6;
  for (const double t : {-0.05, 0.1, 0.2, 0.5}) {
    const Vec2 now = kDrive.pose_at(t).to_world(body);
    const Vec2 slope = (1 / (2 * h)) * (kDrive.pose_at(t + h).to_world(body) -
                                        kDrive.pose_at(t - h).to_world(body));
    const Vec2 velocity = kDrive.velocity_at(t).at(now);
    EXPECT_NEAR(velocity.x, slope.x, 1e-8) << t;
    EXPECT_NEAR(velocity.y, slope.y, 1e-8) << t;
  }
}

}  // namespace
}  // namespace granary::dda
