// Claim: a disk that touches nothing flies its exact parabola at any time step.
// Method: one disk thrown obliquely, steps of 1e-4 and 1e-2 s, 1 s of flight.
// Reference: closed form (PHYSICS A5, first row).
// Tolerance: 1e-12 of the path: rounding of 1e4 additions, 1e4 * 2^-53 = 1e-12.
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

TEST(Projectile, flies_its_exact_parabola_at_any_step) {
  for (const double dt : {1e-4, 1e-2}) {
    System system;
    system.time_step = dt;
    add_disk(system, {0.3, 2}, 0.002, 1000);
    system.disks.motion[0].vx = 3;
    system.disks.motion[0].vy = 4;
    system.disks.motion[0].surface_speed = 0.002 * 5;
    reset_contacts(system);
    run(system, 1);
    EXPECT_NEAR(system.disks.pose[0].x, 0.3 + 3, 5e-12) << dt;
    EXPECT_NEAR(system.disks.pose[0].y, 2 + 4 - 0.5 * 9.81, 5e-12) << dt;
    EXPECT_NEAR(system.disks.motion[0].vy, 4 - 9.81, 1e-11) << dt;
    EXPECT_NEAR(system.disks.pose[0].angle, 5, 5e-12) << dt;
  }
}

}  // namespace
}  // namespace granary::dda
