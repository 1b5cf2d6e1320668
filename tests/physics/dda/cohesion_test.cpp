// Claim: a cohesive contact holds exactly F_c: a disk hangs from a ceiling if and only if F_c > m
// g,
//   and slips on a slope where tan(theta) > mu (1 + F_c / (m g cos(theta))).
// Method: a 4 mm disk at 2 % to either side of both limits; its acceleration beyond the second; a
//   pair pulled apart by spring-free impulses, for the energy of the broken bridge.
// Reference: PHYSICS section I.
// Tolerance: hanging disks sag by less than m g / K = 9e-10 m with K = 1e8 (a bridge is stiffer
// than
//   the penalty), resting ones stretch their spring by less than that and fall by less than
//   g h^2 = 4e-9 m (small step h = 2e-5 s) while it forms; accelerations 1e-3; the bridge's energy
//   is F_c times its range (1 % of the diameter), to a small step's path over that range (1 %).
// Seconds: 0.2
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

constexpr double kRadius = 0.002, kDensity = 730, kGravity = 9.81;
constexpr double kWeight = kDensity * 3.14159265358979 * kRadius * kRadius * kGravity;

System cohesive(double force, bool spins) {
  System system;
  system.contact.stiffness = 1e8;
  system.contact.cohesion = force;
  system.contact.effects = {.rotation = spins, .cohesion = true};
  return system;
}

// Height lost in 0.1 s by a disk that touches a ceiling from below.
double sag(double force) {
  System system = cohesive(force, true);
  add_plane(system, 0, 1);
  add_disk(system, {0, -kRadius}, kRadius, kDensity);
  reset_contacts(system);
  run(system, 0.1);
  EXPECT_GT(system.counters.effects.cohesion, 0u);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
  return -kRadius - system.disks.pose[0].y;
}

TEST(Cohesion, disk_hangs_if_and_only_if_the_bond_exceeds_its_weight) {
  EXPECT_LT(sag(1.02 * kWeight), kWeight / 1e8);
  EXPECT_LT(sag(30 * kWeight), kWeight / 1e8);
  EXPECT_GT(sag(0.98 * kWeight), 1e-4);
  EXPECT_NEAR(sag(0), 0.5 * kGravity * 0.01, 1e-3 * 0.05);
}

struct Slope {
  double path, acceleration;
};

Slope slide_down(double slope_deg, double force) {
  const double angle = radians(slope_deg);
  System system = cohesive(force, false);
  system.contact.friction_walls = 0.3;
  add_plane(system, angle, 2);
  add_disk(system, {-kRadius * std::sin(angle), kRadius * std::cos(angle)}, kRadius, kDensity);
  reset_contacts(system);
  run(system, 0.1);
  const Vec2 downhill{-std::cos(angle), -std::sin(angle)};
  const auto speed = [&] {
    return dot({system.disks.motion[0].vx, system.disks.motion[0].vy}, downhill);
  };
  const double early = speed();
  run(system, 0.1);
  EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
  const Vec2 start{-kRadius * std::sin(angle), kRadius * std::cos(angle)};
  const Vec2 centre{system.disks.pose[0].x, system.disks.pose[0].y};
  return {dot(centre - start, downhill), (speed() - early) / 0.1};
}

TEST(Cohesion, bond_adds_to_the_normal_force_of_coulomb_s_law) {
  const double force = 2 * kWeight;
  const auto strength = [&](double slope_deg) {
    return 0.3 * (1 + force / (kWeight * std::cos(radians(slope_deg))));
  };
  double boundary = 30;
  while (std::tan(radians(boundary)) < strength(boundary)) boundary += 0.01;
  EXPECT_LT(slide_down(boundary - 0.5, force).path, kWeight / 1e8 + 4e-9);
  EXPECT_GT(slide_down(boundary + 0.5, force).path, 1e-4);
  const double angle = radians(60);
  const double expected = kGravity * (std::sin(angle) - std::cos(angle) * strength(60));
  EXPECT_NEAR(slide_down(60, force).acceleration / expected, 1, 1e-3);
}

TEST(Cohesion, breaking_a_bridge_costs_its_force_times_its_range) {
  for (const double dt : {2e-5, 2e-4}) {
    System system = cohesive(0.5, true);
    system.contact.restitution = 1;
    system.gravity = 0;
    system.time_step = dt;
    add_disk(system, {0, 0}, kRadius, kDensity);
    add_disk(system, {2 * kRadius, 0}, kRadius, kDensity);
    const double mass = 1 / system.disks.motion[0].inverse_mass, speed = 0.2;
    system.disks.motion[1].vx = speed;
    reset_contacts(system);
    run(system, 0.02);
    const double bridge = 0.5 * 0.01 * 2 * kRadius;
    const double relative = system.disks.motion[1].vx - system.disks.motion[0].vx;
    const double lost = 0.25 * mass * (speed * speed - relative * relative);
    EXPECT_NEAR(lost / bridge, 1, 0.05) << dt;
    EXPECT_NEAR(system.ledger[core::EnergyChannel::cohesion] / bridge, 1, 0.05) << dt;
    EXPECT_LT(system.ledger.remainder_ratio(), 1e-3);
  }
}

}  // namespace
}  // namespace granary::dda
