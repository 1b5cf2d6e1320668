// Claim: OPEN_CLOSE, direct or PCG, meets the same closed forms as IMPULSE and gives the same step
//   where it converges; its energy ledger closes; growing penalties are paid for in it.
// Method: the scenes of projectile_test, rest_penetration_test, disk_column_test and incline_test;
//   one step of a heap by both solvers; a column on a soft penalty that grows.
// Reference: PHYSICS A2, A5; bucket-elevator paper 4.1 for the growth.
// Tolerance: as in those tests; equal steps to 1e-6 of the speed (both solvers stop at 1e-12).
// Seconds: 0.5
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"
#include "worker/dda/penalty_growth.h"

namespace granary::dda {
namespace {

class OpenClose : public testing::TestWithParam<LinearSolver> {
 protected:
  static constexpr double kTolerance =
      1e-10;  // of the lagged friction; K dt^2 / m = 800 costs 3 digits
  System system_with(double friction, double stiffness) const {
    System system;
    system.solver.method = SolverMethod::open_close;
    system.solver.linear = GetParam();
    system.solver.tolerance = kTolerance;
    system.solver.max_sweeps = 100;
    system.contact.stiffness = stiffness;
    system.contact.friction_disks = system.contact.friction_walls = friction;
    return system;
  }
};

TEST_P(OpenClose, lets_a_disk_fly_its_exact_parabola) {
  System system = system_with(0, 1e7);
  system.time_step = 1e-2;
  add_disk(system, {0.3, 2}, 0.002, 1000);
  system.disks.motion[0].vx = 3;
  system.disks.motion[0].vy = 4;
  reset_contacts(system);
  run(system, 1);
  EXPECT_NEAR(system.disks.pose[0].x, 3.3, 5e-12);
  EXPECT_NEAR(system.disks.pose[0].y, 2 + 4 - 0.5 * 9.81, 5e-12);
}

TEST_P(OpenClose, sinks_in_by_weight_over_stiffness) {
  System system = system_with(0.5, 1e6);
  add_plane(system, 0, 1);
  add_disk(system, {0, 0.002}, 0.002, 1000);
  reset_contacts(system);
  run(system, 0.2);
  const double weight = 9.81 / system.disks.motion[0].inverse_mass;
  EXPECT_NEAR((0.002 - system.disks.pose[0].y) * 1e6 / weight, 1, 1e-9);
  EXPECT_EQ(system.counters.unconverged_steps, 0u);
}

TEST_P(OpenClose, carries_a_column_of_40) {
  System system = system_with(0, 1e6);
  system.time_step = 2e-3;
  add_plane(system, 0, 1);
  for (int k = 0; k < 40; ++k) add_disk(system, {0, (2 * k + 1) * 0.002}, 0.002, 1000);
  reset_contacts(system);
  run(system, 2);
  const double weight = 9.81 / system.disks.motion[0].inverse_mass;
  EXPECT_NEAR((0.002 - system.disks.pose[0].y) * 1e6 / weight, 40, 0.4);
  EXPECT_EQ(system.counters.unconverged_steps, 0u);
}

TEST_P(OpenClose, rolls_and_slips_down_inclines) {
  System rolling = system_with(std::tan(radians(10)), 1e7), slipping = rolling;
  const Downhill rolls = roll_down(rolling, 20), slips = roll_down(slipping, 30);
  EXPECT_EQ(rolling.counters.unconverged_steps + slipping.counters.unconverged_steps, 0u);
  EXPECT_NEAR(rolls.acceleration, 2.0 / 3 * 9.81 * std::sin(radians(20)), 2.2e-6);
  EXPECT_NEAR(rolls.spin_acceleration, rolls.acceleration, 2.2e-6);
  EXPECT_NEAR(slips.acceleration, 3.40698, 3.4e-3);
  EXPECT_NEAR(slips.spin_acceleration, 2.99605, 3.0e-3);
}

// Softly pressed disks in a wedge, sliding: closed, sliding and open contacts in one step.
System heap(SolverMethod method, LinearSolver linear) {
  System system;
  system.solver.method = method;
  system.solver.small_step_kappa = 0;  // one solve per step, as open-close does
  system.solver.linear = linear;
  system.solver.tolerance = 1e-12;
  system.solver.max_sweeps = method == SolverMethod::impulse ? 100000 : 100;
  system.contact.friction_disks = system.contact.friction_walls = 0.3;
  system.contact.stiffness = 1e5;
  system.time_step = 1e-4;
  const std::vector<Vec2> wedge = {{-0.1, 0.1}, {0, 0}, {0.1, 0.1}};
  system.walls.add_chain(wedge, false);
  for (int k = 0; k < 40; ++k)
    add_disk(system, {0.0039 * (k % 6 - 2.6) + 2e-5 * (k % 5), 0.02 + 0.0039 * (k / 6)}, 0.002,
             730);
  for (int k = 0; k < 40; ++k) system.disks.motion[k].vx = 0.05 * std::sin(7.0 * k);
  reset_contacts(system);
  return system;
}

TEST_P(OpenClose, gives_the_step_of_the_impulse_solver) {
  System by_impulses = heap(SolverMethod::impulse, GetParam());
  System by_states = heap(SolverMethod::open_close, GetParam());
  int compared = 0;
  for (int k = 0; k < 20; ++k) {
    by_states.disks = by_impulses.disks;
    by_states.lists = by_impulses.lists;
    by_states.touched = by_impulses.touched;
    step(by_impulses);
    step(by_states);
    ASSERT_TRUE(by_impulses.report.converged);
    if (!by_states.report.converged) continue;
    ++compared;
    for (std::size_t d = 0; d < by_impulses.disks.count(); ++d) {
      const DiskMotion &a = by_impulses.disks.motion[d], &b = by_states.disks.motion[d];
      ASSERT_NEAR(a.vx, b.vx, 1e-6) << k << ' ' << d;
      ASSERT_NEAR(a.vy, b.vy, 1e-6) << k << ' ' << d;
      ASSERT_NEAR(a.surface_speed, b.surface_speed, 1e-6) << k << ' ' << d;
    }
  }
  EXPECT_GE(compared, 15);
}

TEST_P(OpenClose, closes_its_ledger) {
  System system = heap(SolverMethod::open_close, GetParam());
  system.solver.tolerance = 1e-6;
  run(system, 0.1);
  EXPECT_GT(system.ledger[core::EnergyChannel::friction], 0);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
}

TEST_P(OpenClose, grows_a_soft_penalty_until_overlaps_are_tolerable_and_pays_for_it) {
  System system = system_with(0, 1e3);
  system.penalty = {.factor = 1.25, .tolerance = 0.01};
  system.time_step = 1e-3;
  add_plane(system, 0, 1);
  for (int k = 0; k < 10; ++k) add_disk(system, {0, (2 * k + 1) * 0.002}, 0.002, 1000);
  reset_contacts(system);
  run(system, 1);
  const double weight = 9.81 / system.disks.motion[0].inverse_mass;
  // Ten weights on the lowest contact within 1 % of the radius, reached in steps of 25 %.
  const double needed = 10 * weight / (0.01 * 0.002);
  EXPECT_GE(system.contact.stiffness, needed);
  EXPECT_GT(system.counters.penalty_growths, 10u);
  EXPECT_LE(system.contact.stiffness, penalty_cap(system));
  EXPECT_LT(system.ledger[core::EnergyChannel::penalty_change], 0);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
  EXPECT_LE((0.002 - system.disks.pose[0].y) / 0.002, 0.01);
}

INSTANTIATE_TEST_SUITE_P(, OpenClose, testing::Values(LinearSolver::direct, LinearSolver::pcg),
                         [](const auto& info) {
                           return info.param == LinearSolver::direct ? "direct" : "pcg";
                         });

}  // namespace
}  // namespace granary::dda
