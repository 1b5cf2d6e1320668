// Claim: a head-on impact gives back the restitution coefficient that was put in, after the
// collision
//   time and with the greatest overlap of the damped oscillator.
// Method: one bead on the floor and two beads against each other at t_c / 200, no gravity.
// Reference: PHYSICS section A1 (closed form of the damped spring; base case of the chute paper).
// Tolerance: 1e-4 absolute in e_n at t_c / 200 (given there; only an onset exactly on a step is
// worse,
//   5e-4); overlap 0.1 %: the turning point is hit to half a step, (pi / 400)^2 / 2 = 3e-5.
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::tests {
namespace {

template <typename Engine>
class HeadOnImpact : public ::testing::Test {};
TYPED_TEST_SUITE(HeadOnImpact, DemEngines);

constexpr double kWallCollisionTime = 5.96567e-4;
constexpr double kPairCollisionTime = 4.21800e-4;

// Half a step apart at 1 m/s: the onset falls between two steps.
std::vector<dem::Grain> approaching_pair() {
  const double x = 0.0015 + 0.25 * kPairCollisionTime / 200;
  return {grain_at({-x, 0, 0}, {0.5, 0, 0}), grain_at({x, 0, 0}, {-0.5, 0, 0})};
}

TYPED_TEST(HeadOnImpact, wall_returns_normal_restitution) {
  dem::EngineSetup setup = base_setup(kWallCollisionTime / 200);
  setup.walls = {floor_plane()};
  const Bead after = rebound<TypeParam>(setup, {0, 0, -1});
  EXPECT_NEAR(after.velocity.z, 0.95, 1e-4);
}

TYPED_TEST(HeadOnImpact, equal_beads_return_normal_restitution) {
  TypeParam engine(base_setup(kPairCollisionTime / 200));
  engine.insert(approaching_pair());
  engine.advance(220);
  EXPECT_NEAR(bead(engine, 1).velocity.x - bead(engine, 0).velocity.x, 0.97, 1e-4);
  EXPECT_NEAR(bead(engine, 1).velocity.x + bead(engine, 0).velocity.x, 0, 1e-12);
}

TYPED_TEST(HeadOnImpact, greatest_overlap_is_that_of_the_damped_spring) {
  TypeParam engine(base_setup(kPairCollisionTime / 200));
  engine.insert(approaching_pair());
  engine.advance(220);
  EXPECT_NEAR(engine.largest_overlap_ratio() / 2, 0.04408, 1e-3 * 0.04408);
}

// MFiX DEM02: heights of successive bounces h_n = h_0 e^(2n). Per bounce, gravity during the
// contact costs 4 zeta x_s / delta_max = 6e-4 (static overlap x_s = 0.35 um, delta_max = 38 um,
// zeta = .0163), and an onset that happens to fall on a step moves e by up to 5e-4, so the height
// by 1e-3.
TYPED_TEST(HeadOnImpact, bounces_lose_height_as_restitution_squared) {
  dem::EngineSetup setup = base_setup(kWallCollisionTime / 200);
  setup.walls = {floor_plane()};
  setup.motion.gravity = {0, 0, -kGravity};
  TypeParam engine(setup);
  const double drop = 0.002;
  insert_one(engine, grain_at({0, 0, 0.0015 + drop}));
  std::vector<double> tops;
  double before = -1;
  while (tops.size() < 3 && engine.time() < 1) {
    engine.advance(1);
    const Bead now = bead(engine);
    if (before > 0 && now.velocity.z <= 0) tops.push_back(now.position.z - 0.0015);
    before = now.velocity.z;
  }
  ASSERT_EQ(tops.size(), 3U);
  for (std::size_t bounce = 0; bounce < 3; ++bounce) {
    const double expected = drop * std::pow(0.95, 2.0 * static_cast<double>(bounce + 1));
    EXPECT_NEAR(tops[bounce] / expected, 1, 1.6e-3 * static_cast<double>(bounce + 1));
  }
}

}  // namespace
}  // namespace granary::tests
