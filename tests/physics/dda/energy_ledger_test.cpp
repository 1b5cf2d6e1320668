// Claim: the energy ledger closes: its remainder is below 1e-3 of the throughput, and a force that
//   is not booked shows up in it.
// Method: 60 disks dropped into a fixed wedge (impacts, friction, rest); then the same with a
//   velocity kick that no channel knows of.
// Reference: energy balance; PHYSICS section I.
// Tolerance: 1e-3 (section I); the hidden kick of 1 % of the throughput must exceed it.
// Seconds: 0.2
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

System dropped_heap() {
  System system;
  system.contact.friction_disks = system.contact.friction_walls = 0.6;
  system.solver.tolerance = 1e-3;
  const std::vector<Vec2> wedge = {{-0.1, 0.1}, {0, 0}, {0.1, 0.1}};
  system.walls.add_chain(wedge, false);
  for (int k = 0; k < 60; ++k)
    add_disk(system, {0.0042 * (k % 6 - 2.6) + 2e-5 * (k % 5), 0.03 + 0.0043 * (k / 6)}, 0.002,
             730);
  reset_contacts(system);
  return system;
}

TEST(EnergyLedger, closes_while_disks_fall_and_come_to_rest) {
  System system = dropped_heap();
  run(system, 0.5);
  EXPECT_GT(system.ledger[core::EnergyChannel::friction], 0);
  EXPECT_GT(system.ledger[core::EnergyChannel::integrator], 0);
  EXPECT_LT(system.ledger.kinetic_j, 1e-5 * system.ledger.throughput_j);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
}

TEST(EnergyLedger, shows_a_force_that_nobody_booked) {
  System system = dropped_heap();
  run(system, 0.02);
  for (std::size_t k = 0; k < system.disks.count(); ++k) system.disks.motion[k].vy -= 0.05;
  run(system, 0.48);
  EXPECT_GT(system.ledger.remainder_ratio(), 1e-3);
}

// Spins that contacts do not turn rub like walls that move for ever: what they do must be booked.
TEST(EnergyLedger, held_spins_do_work_as_moving_walls_do) {
  System system = dropped_heap();
  system.contact.effects.rotation = false;
  for (std::size_t k = 0; k < system.disks.count(); ++k)
    system.disks.motion[k].surface_speed = -0.1;
  reset_contacts(system);
  run(system, 0.3);
  EXPECT_LT(system.ledger[core::EnergyChannel::wall_work], -0.01 * system.ledger.throughput_j);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
}

// A column on a rising floor: the floor's work is what the disks gain.
TEST(EnergyLedger, wall_work_lifts_a_disk) {
  System system;
  const double mass = 730 * std::numbers::pi * 0.002 * 0.002;
  system.drive = {.rotation_rate = 2, .pulley_radius = 0.5};  // 1 m/s up the belt before time 0
  system.belt_runs = true;
  system.time = -0.2;
  const std::vector<Vec2> floor = {{-0.7, 0}, {-0.3, 0}};
  system.walls.add_chain(floor, true);
  add_disk(system, {-0.5, -0.2 + 0.002}, 0.002, 730);
  system.disks.motion[0].vy = 1;
  reset_contacts(system);
  run(system, 0.1);
  const double lifted = mass * 9.81 * 0.1;
  EXPECT_NEAR(-system.ledger[core::EnergyChannel::wall_work], lifted, 1e-3 * lifted);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
}

}  // namespace
}  // namespace granary::dda
