// Claim: an impact rebounds with the asked normal restitution e whatever the time step, on a wall
//   and between disks, under gravity and in the middle of a step.
// Method: a 3 mm disk (2200 kg/m2) thrown at 1 m/s on a wall, and at a free disk of the same kind;
//   dt from 1e-6 to 1e-3 s, each with eleven distances that put the impact at other phases of a
//   step.
// Reference: PHYSICS section I.
// Tolerance: 0.03 (section I); the elastic overlap of the impact is not allowed to grow the energy.
// Seconds: 0.5
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

constexpr double kRadius = 0.0015, kSpeed = 1;
constexpr int kPhases = 11;

System frictionless(double restitution, double time_step) {
  System system;
  system.contact.restitution = restitution;
  system.time_step = time_step;
  system.gravity = 0;
  return system;
}

// Distances of up to two steps before the impact.
double distance_of(int phase, double time_step) {
  return kSpeed * time_step * (0.05 + 2.0 * phase / kPhases);
}

double rebound_from_wall(double restitution, double time_step, int phase) {
  System system = frictionless(restitution, time_step);
  add_plane(system, 0, 1);
  add_disk(system, {0, kRadius + distance_of(phase, time_step)}, kRadius, 2200);
  system.disks.motion[0].vy = -kSpeed;
  reset_contacts(system);
  run(system, std::max(10 * time_step, 4e-4));
  return system.disks.motion[0].vy / kSpeed;
}

double rebound_of_pair(double restitution, double time_step, int phase) {
  System system = frictionless(restitution, time_step);
  add_disk(system, {0, 0}, kRadius, 2200);
  add_disk(system, {2 * kRadius + distance_of(phase, time_step), 0}, kRadius, 2200);
  system.disks.motion[1].vx = -kSpeed;
  reset_contacts(system);
  run(system, std::max(10 * time_step, 4e-4));
  return (system.disks.motion[1].vx - system.disks.motion[0].vx) / kSpeed;
}

TEST(Restitution, holds_over_time_steps_on_a_wall_and_between_disks) {
  for (const double e : {0.0, 0.3, 0.5, 0.8, 1.0})
    for (const double dt : {1e-6, 1e-5, 5e-5, 1e-4, 2e-4, 1e-3})
      for (int phase = 0; phase < kPhases; ++phase) {
        EXPECT_NEAR(rebound_from_wall(e, dt, phase), e, 0.03) << dt << " " << phase;
        EXPECT_NEAR(rebound_of_pair(e, dt, phase), e, 0.03) << dt << " " << phase;
      }
}

// h_n = h_0 e^(2 n) for three bounces. The step of the impact adds an error of about g dt / v to
// each speed: 2 % of the height at the last bounce.
TEST(Restitution, bounces_lose_height_by_e_squared) {
  for (const double dt : {1e-5, 2e-4}) {
    System system = frictionless(0.7, dt);
    system.gravity = 9.81;
    add_plane(system, 0, 1);
    add_disk(system, {0, kRadius + 0.1}, kRadius, 2200);
    reset_contacts(system);
    double height = 0.1;
    for (int bounce = 1; bounce <= 3; ++bounce) {
      while (system.disks.motion[0].vy <= 0) step(system);
      while (system.disks.motion[0].vy > 0) step(system);
      height *= 0.7 * 0.7;
      EXPECT_NEAR((system.disks.pose[0].y - kRadius) / height, 1, 0.02) << dt << " " << bounce;
    }
    EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
  }
}

// An oblique impact with e keeps the tangential momentum within Coulomb's mu (1 + e) u_n.
TEST(Restitution, friction_of_an_oblique_impact_is_coulomb_s) {
  for (const double dt : {1e-5, 2e-4}) {
    System system = frictionless(0.5, dt);
    system.contact.friction_walls = 0.2;
    add_plane(system, 0, 1);
    add_disk(system, {0, kRadius + 0.3 * dt}, kRadius, 2200);
    system.disks.motion[0].vy = -kSpeed;
    system.disks.motion[0].vx = 3;
    reset_contacts(system);
    run(system, 1e-3);
    EXPECT_NEAR(system.disks.motion[0].vx, 3 - 0.2 * 1.5 * kSpeed, 0.03) << dt;
    EXPECT_NEAR(system.disks.motion[0].surface_speed, -2 * 0.2 * 1.5 * kSpeed, 0.03) << dt;
  }
}

TEST(Restitution, a_disk_dropped_on_a_resting_column_does_not_gain_energy) {
  for (const double e : {0.0, 0.5, 0.9}) {
    System system = frictionless(e, 2e-4);
    system.gravity = 9.81;
    add_plane(system, 0, 1);
    for (int k = 0; k < 5; ++k) add_disk(system, {0, (2 * k + 1) * kRadius}, kRadius, 2200);
    add_disk(system, {0, 11 * kRadius + 0.01}, kRadius, 2200);
    reset_contacts(system);
    const double at_start = system.ledger.stored_j();
    for (int k = 0; k < 2000; ++k) {
      step(system);
      ASSERT_LT(system.ledger.stored_j(), at_start * (1 + 1e-9)) << e << " " << k;
    }
    EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
  }
}

}  // namespace
}  // namespace granary::dda
