// Claim: a disk at rest on a plane tilted by theta sinks in by m g cos(theta) / K and stays.
// Method: 4 mm disk, 1000 kg/m2, K = 1e6 N/m, friction far above tan(theta), 1 s.
// Reference: PHYSICS A5 (.1233 N and 1.23e-7 m at theta = 0).
// Tolerance: 1e-9 of the penetration plus rounding of the centre's coordinate (4e-19 m); on the
//   slope the disk may not creep by more than the tangential spring's m g sin(theta) / K.
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

constexpr double kStiffness = 1e6, kRadius = 0.002, kGravity = 9.81;

System resting_disk(double angle, double friction) {
  System system;
  system.contact.stiffness = kStiffness;
  system.contact.friction_walls = friction;
  system.contact.effects.rotation = angle == 0;
  system.solver.tolerance = 1e-12;
  add_plane(system, angle, 1);
  add_disk(system, {-kRadius * std::sin(angle), kRadius * std::cos(angle)}, kRadius, 1000);
  reset_contacts(system);
  return system;
}

TEST(RestPenetration, is_weight_over_stiffness_on_a_level_plane) {
  System system = resting_disk(0, 0.5);
  run(system, 0.2);
  const double weight = kGravity / system.disks.motion[0].inverse_mass;
  EXPECT_NEAR(weight, 0.1233, 5e-5);
  EXPECT_NEAR((kRadius - system.disks.pose[0].y) * kStiffness / weight, 1, 1e-9);
  EXPECT_NEAR(system.disks.motion[0].vy, 0, 1e-15);
}

TEST(RestPenetration, does_not_creep_on_a_slope_that_friction_holds) {
  for (const double dt : {2e-4, 1e-4, 2e-5}) {
    const double angle = radians(20);
    System system = resting_disk(angle, 0.5);
    system.time_step = dt;
    run(system, 0.5);
    const double weight = kGravity / system.disks.motion[0].inverse_mass;
    const Vec2 centre{system.disks.pose[0].x, system.disks.pose[0].y};
    const Vec2 up{-std::sin(angle), std::cos(angle)}, down{-std::cos(angle), -std::sin(angle)};
    EXPECT_NEAR((kRadius - dot(centre, up)) * kStiffness / (weight * std::cos(angle)), 1, 1e-9);
    EXPECT_NEAR(dot(centre, down) * kStiffness / (weight * std::sin(angle)), 1, 1e-6) << dt;
  }
}

}  // namespace
}  // namespace granary::dda
