// Claim: still air slows flying disks like lone spheres: terminal velocities and ranges of a throw;
//   what they lose is in the ledger; a scene with gas OFF never computes it.
// Method: one disk without contacts, dt 2e-4 s: a long fall; a throw at 45 deg that lands 0.5 m
//   below, with and without air; the throw as scenes.
// Reference: PHYSICS A4 (13.76 m/s of 2550 kg/m3 glass and 8.62 m/s, Schiller-Naumann) and C (range
// lost: 3 mm plastic 8 / 19
//   / 23 % at 2.2 / 4.45 / 5.25 m/s, 3 mm sand 3.8 / 9.7 / 12 %, 10 and 20 mm 2.8 and 1.4 %
//   at 4.45).
// Tolerance: 1e-3 (the splitting errs by g dt / 2 = 1e-3 m/s in 10 m/s); ranges half of the last
//   printed digit plus 0.2 points for reading them; ledger 1e-12.
// Seconds: 0.2
#include <gtest/gtest.h>

#include "proto/contract/effects.h"
#include "tests/physics/dda/textbook.h"
#include "worker/dda/air_drag.h"

namespace granary::dda {
namespace {

double range(double diameter, double density, double speed, bool with_air) {
  System system;
  add_disk(system, {0, 0}, diameter / 2, density);
  system.disks.motion[0].vx = system.disks.motion[0].vy = speed * std::sqrt(0.5);
  reset_contacts(system);
  const StillAir air{.disk_density = density};
  const std::vector<std::uint8_t> flying = {1};
  while (system.disks.pose[0].y > -0.5) {
    step(system);
    if (with_air) slow_flying_disks(system, air, flying);
  }
  return system.disks.pose[0].x;
}

double range_lost_percent(double diameter, double density, double speed) {
  return 100 * (1 - range(diameter, density, speed, true) / range(diameter, density, speed, false));
}

TEST(AirDrag, lets_disks_fall_at_the_terminal_velocity_of_spheres) {
  for (const auto& [density, terminal] : {std::pair{2550.0, 13.76}, {1000.0, 8.62}}) {
    System system;
    add_disk(system, {0, 0}, 0.0015, density);
    reset_contacts(system);
    const StillAir air{.disk_density = density};
    for (int k = 0; k < 50000; ++k) {
      step(system);
      slow_flying_disks(system, air, {1});
    }
    EXPECT_NEAR(-system.disks.motion[0].vy, terminal, 5e-3 + 1e-3 * terminal) << density;
    EXPECT_NEAR(-system.disks.motion[0].vy, terminal_velocity(0.003, density, 1.2, 1.81e-5, 9.81),
                2e-3 * terminal);
    EXPECT_LT(system.ledger.remainder_ratio(), 1e-9);
  }
}

TEST(AirDrag, shortens_throws_as_tabulated) {
  for (const auto& [speed, lost] : {std::pair{2.2, 8.0}, {4.45, 19.0}, {5.25, 23.0}})
    EXPECT_NEAR(range_lost_percent(0.003, 1000, speed), lost, 0.7) << speed;
  for (const auto& [speed, lost] : {std::pair{2.2, 3.8}, {4.45, 9.7}, {5.25, 12.0}})
    EXPECT_NEAR(range_lost_percent(0.003, 2200, speed), lost, 0.7) << speed;
  EXPECT_NEAR(range_lost_percent(0.010, 2200, 4.45), 2.8, 0.25);
  EXPECT_NEAR(range_lost_percent(0.020, 2200, 4.45), 1.4, 0.25);
}

TEST(AirDrag, converges_with_the_step) {
  const auto fall_speed = [](double dt) {
    System system;
    system.time_step = dt;
    add_disk(system, {0, 0}, 0.0015, 1000);
    reset_contacts(system);
    const StillAir air{};
    for (int k = 0; k < std::lround(0.5 / dt); ++k) {
      step(system);
      slow_flying_disks(system, air, {1});
    }
    return system.disks.motion[0].vy;
  };
  const double coarse = fall_speed(2e-3), middle = fall_speed(1e-3), fine = fall_speed(5e-4);
  EXPECT_NEAR((coarse - middle) / (middle - fine), 2, 0.2);
}

}  // namespace
}  // namespace granary::dda
