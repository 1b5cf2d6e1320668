#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
#include "tests/support/shipped_scenes.h"
#include "worker/core/random.h"
#include "worker/scene/discharge.h"

namespace granary::scene {
namespace {

v1::Scene small_scene() {
  std::ifstream file(std::string(GRANARY_SCENES) + "/discharge_small.txtpb");
  std::stringstream text;
  text << file.rdbuf();
  return resolve(*load_scene(text.str(), "discharge_small", {}))->scene;
}

void finish(core::Simulation& simulation, std::uint64_t chunk) {
  while (simulation.advance(1e9, chunk).status == core::AdvanceStatus::advanced) {
  }
}

std::string hash(const core::Simulation& simulation) {
  return core::hash_columns(simulation.physical_state());
}

const std::string& reference_hash() {
  static const std::string value = [] {
    const auto simulation = make_discharge(small_scene());
    finish(*simulation, 1000000);
    return hash(*simulation);
  }();
  return value;
}

TEST(DischargeResume, chunk_size_changes_no_bit) {
  const auto simulation = make_discharge(small_scene());
  finish(*simulation, 37);
  EXPECT_EQ(hash(*simulation), reference_hash());
}

TEST(DischargeResume, continues_bitwise_from_a_snapshot_at_any_step) {
  for (const std::uint64_t steps : {1, 333, 2000, 3100, 4500, 7000}) {
    core::State state;
    {
      const auto first = make_discharge(small_scene());
      first->advance(1e9, steps);
      state = first->snapshot();
    }
    const auto second = make_discharge(small_scene());
    second->restore(state);
    EXPECT_EQ(second->progress().steps, steps);
    finish(*second, 1000000);
    EXPECT_EQ(hash(*second), reference_hash()) << steps;
    EXPECT_LT(second->ledger().remainder_ratio(), 1e-3);
  }
}

// Steps drawn at random over filling, rotation and landing, with every contact law and damping on.
TEST(DischargeResume, continues_bitwise_from_random_steps_with_all_laws) {
  const auto scene =
      tests::shipped_scene("discharge_small", {{"discharge.cohesion_n_per_m", "0.05"},
                                               {"discharge.rolling_friction_coefficient", "0.1"},
                                               {"discharge.damping_per_s", "0.5"},
                                               {"discharge.normal_restitution", "0.3"}});
  const auto whole = make_discharge(scene);
  finish(*whole, 1000000);
  const std::uint64_t last = whole->progress().steps;
  for (std::uint64_t draw = 0; draw < 5; ++draw) {
    const std::uint64_t steps = 1 + core::random_bits(7, 1, draw) % (last - 1);
    const auto first = make_discharge(scene);
    first->advance(1e9, steps);
    const auto second = make_discharge(scene);
    second->restore(first->snapshot());
    finish(*second, 1000000);
    EXPECT_EQ(hash(*second), hash(*whole)) << steps;
    EXPECT_EQ(second->ledger().channels_j, whole->ledger().channels_j) << steps;
  }
}

TEST(DischargeResume, number_of_threads_changes_no_bit) {
  for (const char* threads : {"1", "2", "4", "8"}) {
    const auto simulation =
        make_discharge(tests::shipped_scene("discharge_small", {{"threads", threads}}));
    finish(*simulation, 1000000);
    EXPECT_EQ(hash(*simulation), reference_hash()) << threads;
  }
}

TEST(DischargeResume, stored_filling_changes_no_bit) {
  const auto first = make_discharge(small_scene());
  EXPECT_FALSE(first->stored_filling());
  finish(*first, 1000000);
  ASSERT_TRUE(first->stored_filling());
  const core::State filling = *first->stored_filling();
  const auto second = make_discharge(small_scene(), &filling);
  EXPECT_EQ(second->progress().phase, "rotation");
  finish(*second, 1000000);
  EXPECT_EQ(hash(*second), reference_hash());
  EXPECT_EQ(second->observe().values[0].value, first->observe().values[0].value);
}

TEST(DischargeResume, refuses_the_state_of_something_else) {
  const auto simulation = make_discharge(small_scene());
  core::State other;
  other.put_scalar("time", "s", 1.0);
  EXPECT_THROW(simulation->restore(other), std::runtime_error);
}

TEST(DischargeProgress, time_never_runs_backwards_and_the_fraction_ends_at_one) {
  const auto simulation = make_discharge(small_scene());
  double time = -1e300, fraction = 0;
  while (simulation->advance(1e9, 100).status == core::AdvanceStatus::advanced) {
    const core::SimulationProgress progress = simulation->progress();
    EXPECT_GT(progress.time_s, time);
    EXPECT_GE(progress.fraction, fraction);
    EXPECT_LE(progress.fraction, 1);
    time = progress.time_s;
    fraction = progress.fraction;
  }
  EXPECT_EQ(simulation->progress().fraction, 1);
}

}  // namespace
}  // namespace granary::scene
