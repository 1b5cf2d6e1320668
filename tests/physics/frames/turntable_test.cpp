// Claim: a ball that rolls without slip on a turning table turns its laboratory velocity at exactly
//   2/7 of the table's rate, with constant speed. Coriolis force, Coriolis torque and contact
//   torque must all be right for that.
// Method: level plane, Omega = 1.6755 rad/s up, 0.2 m/s across the centre, 3 s, both frames.
// Reference: PHYSICS section A3, row 5.
// Tolerance: 1e-4 of the rate: the start-up of the tangential spring changes the rolling speed by
//   (m a / k_t) / (v t_c) ~ 1e-5; dt error is second order (FreeGrain).
// Seconds: 0.5
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::tests {
namespace {

template <typename Engine>
class Turntable : public ::testing::Test {};
TYPED_TEST_SUITE(Turntable, DemEngines);

constexpr double kOmega = 1.6755161;
constexpr double kRadius = 0.0015;

core::Vec3 laboratory_velocity(const Bead& b, double time) {
  const core::Vec3 omega{0, 0, kOmega};
  return core::rotation_matrix(omega * time) * (b.velocity + cross(omega, b.position));
}

template <typename Engine>
void expect_two_sevenths(dem::FrameKind frame) {
  dem::EngineSetup setup = base_setup(1e-5);
  setup.walls = {floor_plane()};
  setup.motion = {
      .gravity = {0, 0, -kGravity}, .omega = {0, 0, kOmega}, .axis_point = {}, .frame = frame};
  const auto engine = engine_for<Engine>(setup);
  const double sunk = kGravity * setup.classes[0].mass() / 1000;
  const core::Vec3 start{-0.1, 0, kRadius - sunk};
  const core::Vec3 velocity = core::Vec3{0.2, 0, 0} - cross(setup.motion.omega, start);
  insert_one(*engine, grain_at(start, velocity, cross({0, 0, 1}, velocity) * (1 / kRadius)));
  const core::Vec3 before = laboratory_velocity(bead(*engine), 0);
  engine->advance(300'000);
  const core::Vec3 after = laboratory_velocity(bead(*engine), 3);
  EXPECT_NEAR(norm(after) / norm(before), 1, 1e-4);
  const double angle = std::atan2(after.y, after.x) - std::atan2(before.y, before.x);
  EXPECT_NEAR(angle / (2.0 / 7.0 * kOmega * 3), 1, 1e-4);
}

TYPED_TEST(Turntable, ball_turns_at_two_sevenths_seen_corotating) {
  expect_two_sevenths<TypeParam>(dem::FrameKind::corotating);
}

TYPED_TEST(Turntable, ball_turns_at_two_sevenths_seen_inertial) {
  expect_two_sevenths<TypeParam>(dem::FrameKind::inertial);
}

}  // namespace
}  // namespace granary::tests
