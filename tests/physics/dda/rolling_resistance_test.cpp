// Claim: with rolling resistance mu_r a disk on an incline rests while tan(theta) < mu_r, rolls
// with
//   a = 2/3 g (sin - mu_r cos) up to tan(theta) = 3 mu - 2 mu_r, and beyond slips with
//   a = g (sin - mu cos), r alpha = 2 (mu - mu_r) g cos. A spinning pair of unlike disks loses its
//   relative turning, and only that, to the resistance.
// Method: 4 mm disk, mu = tan 20 deg, mu_r = 0.1, dt = 1e-3 s, 0.2 s; two unlike disks pressed
//   together by a wall and a weight, without friction.
// Reference: PHYSICS A2 (k = 1/2), section I.
// Tolerance: rest 1e-9 m; accelerations 1e-3 (A2).
// Seconds: 0.2
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

constexpr double kFriction = 0.36397, kRolling = 0.1, kGravity = 9.81;

struct Downhill {
  double path, acceleration, spin_acceleration;
};

Downhill measure(double slope_deg, double rolling_friction, double time_step) {
  const double angle = radians(slope_deg), radius = 0.002;
  System system;
  system.time_step = time_step;
  system.contact.friction_walls = kFriction;
  system.contact.rolling_friction = rolling_friction;
  system.contact.effects.rolling = true;
  add_plane(system, angle, 2);
  const Vec2 start{-radius * std::sin(angle), radius * std::cos(angle)};
  add_disk(system, start, radius, 1000);
  reset_contacts(system);
  run(system, 0.1);
  const DiskMotion early = system.disks.motion[0];
  run(system, 0.2);
  const DiskMotion late = system.disks.motion[0];
  EXPECT_GT(system.counters.effects.rolling, 0u);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
  const Vec2 along{std::cos(angle), std::sin(angle)};
  return {-dot(Vec2{system.disks.pose[0].x, system.disks.pose[0].y} - start, along),
          -dot({late.vx - early.vx, late.vy - early.vy}, along) / 0.2,
          (late.surface_speed - early.surface_speed) / 0.2};
}

TEST(RollingResistance, disk_rests_below_the_angle_of_rolling_friction) {
  const double boundary = std::atan(kRolling) * 180 / std::numbers::pi;
  for (const double dt : {1e-3, 2e-4}) {
    EXPECT_LT(measure(boundary - 0.2, kRolling, dt).path, 2e-8);
    EXPECT_GT(measure(boundary + 0.2, kRolling, dt).path, 1e-4);
  }
}

TEST(RollingResistance, slows_a_rolling_disk) {
  const double angle = radians(20);
  const Downhill motion = measure(20, kRolling, 1e-3);
  const double expected = kGravity * (std::sin(angle) - kRolling * std::cos(angle)) / 1.5;
  EXPECT_NEAR(motion.acceleration / expected, 1, 1e-3);
  EXPECT_NEAR(motion.spin_acceleration / expected, 1, 1e-3);
}

TEST(RollingResistance, slows_the_spin_of_a_slipping_disk) {
  const double boundary = std::atan(3 * kFriction - 2 * kRolling) * 180 / std::numbers::pi;
  const Downhill below = measure(boundary - 0.5, kRolling, 1e-3);
  EXPECT_NEAR(below.spin_acceleration / below.acceleration, 1, 1e-4);
  const double angle = radians(boundary + 3);
  const Downhill above = measure(boundary + 3, kRolling, 1e-3);
  EXPECT_NEAR(above.acceleration / (kGravity * (std::sin(angle) - kFriction * std::cos(angle))), 1,
              1e-3);
  EXPECT_NEAR(above.spin_acceleration / (2 * (kFriction - kRolling) * kGravity * std::cos(angle)),
              1, 1e-3);
}

// Without friction a pair in line with gravity only exchanges the torque T = mu_r R P_n: angular
// momentum I1 w1 + I2 w2 stays, the relative turning dies.
TEST(RollingResistance, stops_the_relative_turning_of_unlike_disks_and_keeps_their_spin) {
  System system;
  system.contact.rolling_friction = 0.3;
  system.contact.effects.rolling = true;
  add_plane(system, 0, 1);
  add_disk(system, {0, 0.003}, 0.003, 1000);
  add_disk(system, {0, 0.008}, 0.002, 1000);
  const auto inertia = [&](std::size_t k) {
    const double radius = system.disks.pose[k].radius;
    return 0.5 * radius * radius / system.disks.motion[k].inverse_mass;
  };
  const auto spin = [&](std::size_t k) {
    return system.disks.motion[k].surface_speed / system.disks.pose[k].radius;
  };
  reset_contacts(system);
  run(system, 0.01);  // so that the disks press when the spin starts
  system.disks.motion[1].surface_speed = 0.02;
  const double start = spin(1);
  step(system);
  const double force = 9.81 / system.disks.motion[1].inverse_mass;
  const double arm = 2 * 0.003 * 0.002 / 0.005;
  EXPECT_NEAR((start - spin(1)) / (0.3 * arm * force * system.time_step / inertia(1)), 1, 1e-3);
  run(system, 0.1);
  EXPECT_NEAR(spin(0), 0, 1e-6);  // the floor resists, too, and it does not turn
  EXPECT_NEAR(spin(1), 0, 1e-6);
}

}  // namespace
}  // namespace granary::dda
