// Claim: the damping matrix C = c M of Eq. 3 slows a free disk by exp(-c t), lets a falling one
// tend
//   to g / c, and its loss is booked; both solvers know it.
// Method: one 4 mm disk without contacts, c = 40 / s, 0.2 s.
// Reference: M v' = -C v + F.
// Tolerance: decay exact to rounding; the fall is split from the damping, so first order: the
//   terminal speed is g dt / (1 - exp(-c dt)) - g dt, within c dt / 2 = 0.4 % of g / c.
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

System damped(SolverMethod method) {
  System system;
  system.solver.method = method;
  system.damping_rate = 40;
  add_disk(system, {0, 0}, 0.002, 730);
  return system;
}

TEST(MassDamping, slows_a_free_disk_exponentially) {
  for (const SolverMethod method : {SolverMethod::impulse, SolverMethod::open_close}) {
    System system = damped(method);
    system.gravity = 0;
    system.disks.motion[0].vx = 3;
    system.disks.motion[0].surface_speed = 2;
    reset_contacts(system);
    run(system, 0.2);
    EXPECT_NEAR(system.disks.motion[0].vx / (3 * std::exp(-8)), 1, 1e-10);
    EXPECT_NEAR(system.disks.motion[0].surface_speed / (2 * std::exp(-8)), 1, 1e-10);
    EXPECT_LT(system.ledger.remainder_ratio(), 1e-12);
  }
}

TEST(MassDamping, limits_the_speed_of_a_falling_disk) {
  System system = damped(SolverMethod::impulse);
  reset_contacts(system);
  run(system, 0.5);
  EXPECT_NEAR(-system.disks.motion[0].vy / (9.81 / 40), 1, 0.5 * 40 * system.time_step + 1e-6);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-12);
}

}  // namespace
}  // namespace granary::dda
