// Claim: a disk on an incline rolls with a = 2/3 g sin(theta) while tan(theta) < 3 mu, and beyond
//   slips with a = g (sin - mu cos) while its spin grows with r alpha = 2 mu g cos(theta).
// Method: 4 mm disk, mu = tan 10 deg, K = 1e7 N/m, dt = 1e-3 s, 0.2 s, against the plane's angle.
// Reference: PHYSICS A2: 2.23681 (20 deg, rolls); 3.40698 and 2.99605 (30 deg, slips).
// Tolerance: 1e-6 rolling, 1e-3 slipping (A2, A5). The transient is one elastic stretch of the
//   springs: mu m g / K = 1e-9 m against a path of 4e-2 m.
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

Downhill measure(double slope_deg) {
  System system;
  system.contact.friction_walls = std::tan(radians(10));
  system.solver.tolerance = 1e-12;
  return roll_down(system, slope_deg);
}

TEST(Incline, disk_rolls_below_the_slip_boundary) {
  const Downhill motion = measure(20);
  EXPECT_NEAR(motion.acceleration, 2.0 / 3 * 9.81 * std::sin(radians(20)), 2.2e-6);
  EXPECT_NEAR(motion.acceleration, 2.23681, 5e-6);
  EXPECT_NEAR(motion.spin_acceleration, motion.acceleration, 2.2e-6);
}

TEST(Incline, disk_slips_and_spins_above_the_slip_boundary) {
  const Downhill motion = measure(30);
  EXPECT_NEAR(motion.acceleration, 3.40698, 3.4e-3);
  EXPECT_NEAR(motion.spin_acceleration, 2.99605, 3.0e-3);
}

TEST(Incline, boundary_between_rolling_and_slipping_is_tan_theta_equal_three_mu) {
  const double boundary = 27.88;  // deg, A2
  const Downhill below = measure(boundary - 0.5), above = measure(boundary + 0.5);
  EXPECT_NEAR(below.spin_acceleration / below.acceleration, 1, 1e-5);
  EXPECT_LT(above.spin_acceleration / above.acceleration, 0.99);
}

}  // namespace
}  // namespace granary::dda
