// Claim: one bead in the rotating chute leaves when and as fast as the closed form says, with and
//   without friction, and both frames follow the same path.
// Method: floor and one side wall, axis through the bead's line at the inlet, v0 .2731 m/s, 0.9 m,
//   16 rpm, 30 and 40 deg, dt 1e-5; spin locked where the reference has none.
// Reference: PHYSICS section A3, rows 6 (hyperbolic functions) and 7 (linear equation, solved here
// by
//   its exponentials).
// Tolerance: 1e-4 without friction (soft wall: side overlap 2 Omega v m / k < 0.4 um out of mm
// paths);
//   2e-3 with friction (the side wall is reached during the first 0.4 um). Paths of the two frames:
//   1e-6 m (issue: single particle the same path to 1e-6).
// Seconds: 0.3
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::tests {
namespace {

template <typename Engine>
class BeadInRotatingChute : public ::testing::Test {};
TYPED_TEST_SUITE(BeadInRotatingChute, DemEngines);

constexpr double kRadius = 0.0015;
constexpr double kLength = 0.9;
constexpr double kStartSpeed = 0.2731;

dem::EngineSetup chute_setup(double degrees, double friction) {
  dem::EngineSetup setup = base_setup(1e-5);
  setup.walls = {floor_plane(), {{0, kRadius, 0}, {0, -1, 0}}};
  setup.motion.gravity = gravity_on_slope(degrees);
  setup.motion.omega = chute_omega(16, degrees);
  setup.motion.axis_point = {0, 0, kRadius};
  setup.grain_wall.friction = friction;
  setup.outlet_x = kLength;
  return setup;
}

template <typename Engine>
dem::Leaver slide_down(const dem::EngineSetup& setup) {
  Engine engine(setup);
  const double sunk = -setup.motion.gravity.z * setup.classes[0].mass() / 1000;
  insert_one(engine, grain_at({0, 0, kRadius - sunk}, {kStartSpeed, 0, 0}));
  while (engine.grain_count() > 0 && engine.time() < 2) engine.advance(24);
  const auto leavers = engine.take_leavers();
  EXPECT_EQ(leavers.size(), 1U);
  return leavers.empty() ? dem::Leaver{} : leavers[0];
}

TYPED_TEST(BeadInRotatingChute, frictionless_bead_leaves_at_the_hyperbolic_time) {
  struct Row {
    double degrees, time, speed;
  };
  for (const Row& row : {Row{30, .535255, 3.25715}, Row{40, .483025, 3.57202}}) {
    const dem::Leaver leaver = slide_down<TypeParam>(chute_setup(row.degrees, 0));
    EXPECT_NEAR(leaver.time / row.time, 1, 1e-4) << row.degrees;
    EXPECT_NEAR(leaver.velocity.x / row.speed, 1, 1e-4) << row.degrees;
  }
}

TYPED_TEST(BeadInRotatingChute, frictionless_bead_at_rest_chute_gains_its_fall) {
  struct Row {
    double degrees, speed;
  };
  for (const Row& row : {Row{30, 2.98389}, Row{40, 3.38008}}) {
    dem::EngineSetup setup = chute_setup(row.degrees, 0);
    setup.motion.omega = {};
    EXPECT_NEAR(slide_down<TypeParam>(setup).velocity.x / row.speed, 1, 1e-4) << row.degrees;
  }
}

// s'' + 2 b s' - c s = f, s(0) = 0, s'(0) = v0.
double time_of_linear_slide(double b, double c, double f, double length) {
  const double root = std::sqrt(b * b + c);
  const double fast = -b + root;
  const double slow = -b - root;
  const double rest = -f / c;
  const double a1 = (kStartSpeed + slow * rest) / (fast - slow);
  const double a2 = -rest - a1;
  const auto travelled = [&](double t) {
    return rest + a1 * std::exp(fast * t) + a2 * std::exp(slow * t);
  };
  double low = 0;
  double high = 2;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (travelled(middle) < length ? low : high) = middle;
  }
  return low;
}

TYPED_TEST(BeadInRotatingChute, locked_bead_with_friction_on_floor_and_side) {
  for (const double degrees : {30.0, 40.0}) {
    const double mu = 0.22;
    dem::EngineSetup setup = chute_setup(degrees, mu);
    setup.effects.spin = false;
    const double rate = 16 * 2 * std::numbers::pi / 60;
    const double sine = std::sin(radians(degrees));
    const double cosine = std::cos(radians(degrees));
    const double expected =
        time_of_linear_slide(mu * rate * cosine, rate * rate * cosine * (cosine + mu * sine),
                             kGravity * (sine - mu * cosine), kLength);
    EXPECT_NEAR(slide_down<TypeParam>(setup).time / expected, 1, 2e-3) << degrees;
  }
}

template <typename Engine>
void expect_same_path(const dem::Grain& grain, double duration) {
  dem::EngineSetup corotating = chute_setup(30, 0.22);
  corotating.motion.axis_point = {0.165, 0.04, 0};
  corotating.grain_wall.rolling_friction = 0.05;
  dem::EngineSetup inertial = corotating;
  inertial.motion.frame = dem::FrameKind::inertial;
  const auto here = engine_for<Engine>(corotating);
  const auto there = engine_for<Engine>(inertial);
  insert_one(*here, grain);
  insert_one(*there, grain);
  while (here->time() < duration) {
    here->advance(1'000);
    there->advance(1'000);
    ASSERT_NEAR(norm(bead(*here).position - bead(*there).position), 0, 1e-6) << here->time();
  }
}

TYPED_TEST(BeadInRotatingChute, both_frames_follow_the_same_sliding_path) {
  expect_same_path<TypeParam>(
      grain_at({0.01, -0.004, 0.0015}, {kStartSpeed, 0.02, 0}, {5, 10, -20}), 0.5);
}

// Each bounce multiplies what separates the paths, so a bouncing bead is followed for less long.
TYPED_TEST(BeadInRotatingChute, both_frames_follow_the_same_bouncing_path) {
  expect_same_path<TypeParam>(grain_at({0.01, -0.004, 0.0025}, {kStartSpeed, 0.1, 0}, {5, 10, -20}),
                              0.3);
}

}  // namespace
}  // namespace granary::tests
