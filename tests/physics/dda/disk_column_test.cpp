// Claim: in a column of 40 disks contact k from the top carries k weights; the lowest overlap is
//   40 m g / K = 1.2e-2 d at K = 1e5, 1.2e-3 d at 1e6, 1.2e-4 d at 1e7.
// Method: 4 mm disks of 1000 kg/m2 one above the other, settled for 2 s at dt = 2e-3 s,
//   whose numerical damping (omega^2 dt / 2 >= 12 per second for the slowest mode, K = 1e5) ends
//   the oscillation.
// Reference: PHYSICS A5.
// Tolerance: 1 % (the sweeps end at a relative change of 1e-7 per sweep; the slowest mode of 40
//   contacts decays by about 1 - (pi / 40)^2 / 2 = 0.997 per sweep, so the error is ~3e-5).
// Seconds: 1
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

TEST(DiskColumn, carries_its_weight_contact_by_contact) {
  constexpr int kCount = 40;
  constexpr double kRadius = 0.002;
  for (const double stiffness : {1e5, 1e6, 1e7}) {
    System system;
    system.contact.stiffness = stiffness;
    system.time_step = 2e-3;
    system.solver.tolerance = 1e-7;
    system.solver.max_sweeps = 5000;
    add_plane(system, 0, 1);
    for (int k = 0; k < kCount; ++k) add_disk(system, {0, (2 * k + 1) * kRadius}, kRadius, 1000);
    reset_contacts(system);
    run(system, 2);
    const double weight = 9.81 / system.disks.motion[0].inverse_mass;
    const double lowest = kRadius - system.disks.pose[0].y;
    const double highest =
        2 * kRadius - (system.disks.pose[kCount - 1].y - system.disks.pose[kCount - 2].y);
    EXPECT_NEAR(lowest * stiffness / weight, kCount, 0.01 * kCount) << stiffness;
    EXPECT_NEAR(highest * stiffness / weight, 1, 0.01) << stiffness;
    EXPECT_NEAR(lowest / (2 * kRadius), 1.233e3 / stiffness, 1.5e1 / stiffness);
  }
}

}  // namespace
}  // namespace granary::dda
