// Claim: the energy ledger books nothing as a difference: what a force does that is in no channel
// shows
//   in the remainder, with its full amount.
// Method: the velocity of one body is changed between two steps, as a force would that nobody
// booked;
//   a twin without the push runs beside it.
// Reference: the work of the push, m (2 v dv + dv^2) / 2.
// Tolerance: 1e-6 of that work, plus the twin's own remainder (it closes to rounding for DDA, to
// second
//   order for DEM). Seconds: 1.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "proto/contract/resolve.h"
#include "tests/stability/hard_case.h"
#include "worker/scene/chute.h"
#include "worker/scene/discharge.h"

namespace granary::stability {
namespace {

using testing::velocity_jumps_by;

// The first body of either scene is in free flight, across gravity in the chute (y), along it in
// the discharge: the push comes before anything has moved there.
struct Pushed {
  const char* scene;
  double mass_kg;
};

constexpr double kPush = 0.5;  // m/s

const Pushed kPushed[] = {
    {"chute { length_m: 0.2 inclination_deg: 0 duration_s: 0.02 closed_end: true\n"
     "particles { diameter_m: 0.003 density_kg_per_m3: 2550 }\n"
     "contact_pp { normal_restitution: 0.9 tangential_restitution: 0.33 friction_coefficient: 0.3 "
     "}\n"
     "contact_pw { normal_restitution: 0.9 tangential_restitution: 0.33 friction_coefficient: 0.3 "
     "}\n"
     "inlet { feed: NONE } beads { x_m: 0.1 y_m: 0.04 z_m: 0.04 } }\n"
     "effects { gas: OFF }",
     2550 * std::numbers::pi / 6 * 0.003 * 0.003 * 0.003},
    {"discharge { filling: EXPLICIT no_bucket: true duration_s: 0.02 gravity_m_per_s2: 0\n"
     "particles { density_kg_per_m3: 730 } friction_pp_deg: 20 friction_pw_deg: 20\n"
     "discs { x_m: 0 y_m: 0.5 diameter_m: 0.004 }\n"
     "discs { x_m: 0.1 y_m: 0.5 diameter_m: 0.004 vx_m_per_s: 1 }\n"
     "walls { points { x_m: -1 y_m: 0 } points { x_m: 1 y_m: 0 } } }\n"
     "effects { gas: OFF }",
     730 * std::numbers::pi * 0.002 * 0.002}};

std::unique_ptr<core::Simulation> engine_of(const v1::Scene& scene) {
  if (scene.has_discharge()) return scene::make_discharge(scene, nullptr);
  return scene::make_chute(scene, nullptr);
}

class WrongForce : public ::testing::TestWithParam<Pushed> {};

TEST_P(WrongForce, shows_in_the_remainder_with_its_full_work) {
  const auto scene = load_scene(GetParam().scene, "pushed.txtpb", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const auto resolved = resolve(*scene);
  ASSERT_TRUE(resolved) << resolved.error().message;
  const auto twin = engine_of(resolved->scene);
  const auto pushed = engine_of(resolved->scene);
  twin->advance(1e9, 20);
  pushed->advance(1e9, 20);
  core::State state = pushed->snapshot();
  velocity_jumps_by(kPush)(state);
  pushed->restore(state);
  twin->advance(1e9, 64);
  pushed->advance(1e9, 64);
  const double work = 0.5 * GetParam().mass_kg * kPush * kPush;
  const double own = std::abs(twin->ledger().remainder_j());
  EXPECT_NEAR(pushed->ledger().remainder_j(), work, 1e-6 * work + own);
  EXPECT_LT(own, 1e-3 * work);
}

// A filling keeps stored energies alone: they may fall, and whatever rises in any step adds up.
TEST(WrongForceInFilling, adds_up_as_energy_from_nowhere) {
  const auto scene = load_scene(
      "discharge { particles { count: 30 diameter_min_m: 0.01 density_kg_per_m3: 2200 }\n"
      "bucket { tip_x_m: -0.1 tip_y_m: 0.1 } friction_pp_deg: 30 friction_pw_deg: 20\n"
      "rotation_rad_per_s: 10 }\n"
      "effects { gas: OFF }",
      "filling.txtpb", {});
  ASSERT_TRUE(scene) << scene.error().message;
  const auto resolved = resolve(*scene);
  ASSERT_TRUE(resolved) << resolved.error().message;
  const auto twin = engine_of(resolved->scene);
  const auto pushed = engine_of(resolved->scene);
  const double mass = 2200 * std::numbers::pi * 0.005 * 0.005;
  constexpr int kPushes = 3;
  for (int k = 0; k < kPushes; ++k) {
    twin->advance(1e9, 20);
    pushed->advance(1e9, 20);
    core::State state = pushed->snapshot();
    velocity_jumps_by(kPush)(state);
    pushed->restore(state);
  }
  twin->advance(1e9, 200);
  pushed->advance(1e9, 200);
  ASSERT_NE(pushed->progress().phase.find("filling"), std::string::npos);
  // A push finds the disk falling by at most g t: m (dv^2 / 2 - g t dv) is left of its work.
  const double fall = 9.81 * 60 * 2e-4;
  EXPECT_GT(pushed->ledger().remainder_j(), kPushes * mass * kPush * (kPush / 2 - fall));
  EXPECT_LT(std::abs(twin->ledger().remainder_j()), 1e-3 * twin->ledger().throughput_j);
}

INSTANTIATE_TEST_SUITE_P(, WrongForce, ::testing::ValuesIn(kPushed), [](const auto& info) {
  return std::string(info.index == 0 ? "dem" : "dda");
});

}  // namespace
}  // namespace granary::stability
