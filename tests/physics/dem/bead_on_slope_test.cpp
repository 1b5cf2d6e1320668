// Claim: one bead on a slope rests, rolls, or slips and rolls exactly where rigid-body mechanics
// says. Method: bead at its static overlap, at rest; acceleration and spin rate between 0.1 and 0.2
// s. Reference: PHYSICS section A2 (solid sphere): roll a = g (sin - mu_r cos)/(7/5); slip and roll
//   a = g (sin - mu cos), R alpha = 5/2 (mu - mu_r) g cos; slip starts at tan = 7/2 mu - 5/2 mu_r.
// Tolerance: 1e-3 relative (start-up transient of the tangential spring, given there). Resting: the
//   static displacement of the springs is m g / k = 0.4 um.
// Seconds: 0.3
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::tests {
namespace {

template <typename Engine>
class BeadOnSlope : public ::testing::Test {};
TYPED_TEST_SUITE(BeadOnSlope, DemEngines);

constexpr double kRadius = 0.0015;

dem::EngineSetup slope_setup(double degrees, double friction, double rolling_friction) {
  dem::EngineSetup setup = base_setup(1e-5);
  setup.walls = {floor_plane()};
  setup.motion.gravity = gravity_on_slope(degrees);
  setup.grain_wall.friction = friction;
  setup.grain_wall.rolling_friction = rolling_friction;
  return setup;
}

// Sunk into the floor by its own weight.
void lay_bead(dem::Engine& engine, const core::Vec3& velocity = {}) {
  const dem::EngineSetup& setup = engine.setup();
  const double sunk = -setup.motion.gravity.z * setup.classes[0].mass() / 1000;
  insert_one(engine, grain_at({0, 0, kRadius - sunk}, velocity));
}

struct Rates {
  double acceleration, surface_acceleration;
};

template <typename Engine>
Rates rates_of(const dem::EngineSetup& setup) {
  Engine engine(setup);
  lay_bead(engine);
  engine.advance(10'000);
  const Bead early = bead(engine);
  engine.advance(10'000);
  const Bead late = bead(engine);
  return {(late.velocity.x - early.velocity.x) / 0.1, kRadius * (late.spin.y - early.spin.y) / 0.1};
}

TYPED_TEST(BeadOnSlope, rolls_without_slip_below_the_boundary) {
  const Rates rates = rates_of<TypeParam>(slope_setup(30, 0.22, 0));
  EXPECT_NEAR(rates.acceleration, 3.50357, 3.5e-3);
  EXPECT_NEAR(rates.surface_acceleration, 3.50357, 3.5e-3);
}

TYPED_TEST(BeadOnSlope, slips_and_rolls_above_the_boundary) {
  const Rates rates = rates_of<TypeParam>(slope_setup(40, 0.22, 0));
  EXPECT_NEAR(rates.acceleration, 4.65247, 4.7e-3);
  EXPECT_NEAR(rates.surface_acceleration, 4.13319, 4.1e-3);
}

TYPED_TEST(BeadOnSlope, rolling_friction_shifts_the_slip_boundary) {
  const Rates rates = rates_of<TypeParam>(slope_setup(30, 0.22, 0.1));
  EXPECT_NEAR(rates.acceleration, 3.03594, 3.0e-3);
  EXPECT_NEAR(rates.surface_acceleration, 2.54871, 2.5e-3);
}

TYPED_TEST(BeadOnSlope, rolling_friction_slows_rolling) {
  const Rates rates = rates_of<TypeParam>(slope_setup(20, 0.22, 0.1));
  EXPECT_NEAR(rates.acceleration, 1.73813, 1.7e-3);
}

TYPED_TEST(BeadOnSlope, rests_below_the_rolling_friction_angle) {
  TypeParam engine(slope_setup(5, 0.22, 0.1));
  lay_bead(engine);
  engine.advance(50'000);
  EXPECT_LT(std::abs(bead(engine).position.x), 1e-6);
  // The velocity shown is that of the half step plus half a step of gravity.
  EXPECT_LT(norm(bead(engine).velocity), 0.51e-5 * kGravity);
}

TYPED_TEST(BeadOnSlope, slides_unrotated_when_rolling_friction_reaches_friction) {
  const Rates rates = rates_of<TypeParam>(slope_setup(30, 0.22, 0.3));
  EXPECT_NEAR(rates.acceleration, kGravity * (0.5 - 0.22 * std::cos(radians(30))), 3e-3);
  EXPECT_NEAR(rates.surface_acceleration, 0, 1e-4);
}

TYPED_TEST(BeadOnSlope, locked_spin_slides) {
  dem::EngineSetup setup = slope_setup(30, 0.22, 0);
  setup.effects.spin = false;
  const Rates rates = rates_of<TypeParam>(setup);
  EXPECT_NEAR(rates.acceleration, kGravity * (0.5 - 0.22 * std::cos(radians(30))), 3e-3);
}

// MFiX DEM04: launched sliding on a level rough plane, a sphere rolls from t = (2/7) v0 / (mu g)
// on, with v = (5/7) v0.
TYPED_TEST(BeadOnSlope, launched_sliding_it_ends_up_rolling) {
  TypeParam engine(slope_setup(0, 0.22, 0));
  lay_bead(engine, {0.5, 0, 0});
  const double rolling_from = 2.0 / 7.0 * 0.5 / (0.22 * kGravity);
  engine.advance(static_cast<std::uint64_t>(0.9 * rolling_from / 1e-5));
  const Bead sliding = bead(engine);
  EXPECT_NEAR(sliding.velocity.x, 0.5 - 0.22 * kGravity * 0.9 * rolling_from, 5e-4);
  EXPECT_GT(sliding.velocity.x - kRadius * sliding.spin.y, 0.04);
  engine.advance(10'000);
  const Bead rolling = bead(engine);
  EXPECT_NEAR(rolling.velocity.x, 5.0 / 7.0 * 0.5, 5e-4);
  EXPECT_NEAR(kRadius * rolling.spin.y, 5.0 / 7.0 * 0.5, 5e-4);
}

// MFiX DEM03 in miniature: two beads at rest on each other; k (floor) carries both, k (pair) one.
TYPED_TEST(BeadOnSlope, stacked_beads_rest_at_their_static_overlaps) {
  dem::EngineSetup setup = slope_setup(0, 0.22, 0);
  setup.grain_grain.normal_restitution = setup.grain_wall.normal_restitution = 0.3;
  TypeParam engine(setup);
  const std::vector<dem::Grain> stack = {grain_at({0, 0, kRadius}), grain_at({0, 0, 3 * kRadius})};
  engine.insert(stack);
  engine.advance(20'000);
  const double weight = setup.classes[0].mass() * kGravity;
  const double lower = kRadius - bead(engine, 0).position.z;
  const double upper = 2 * kRadius - (bead(engine, 1).position.z - bead(engine, 0).position.z);
  EXPECT_NEAR(lower, 2 * weight / 1000, 1e-3 * weight / 1000);
  EXPECT_NEAR(upper, weight / 1000, 1e-3 * weight / 1000);
}

}  // namespace
}  // namespace granary::tests
