// Claim: a chute run is one computation, whatever its chunks and checkpoints; its inlet delivers
// the
//   mass flow; its energy ledger closes and shows a force that is not accounted for.
// Method: chute_small, shortened.
// Reference: PHYSICS section A6 (cumulative mass = flow x t to one layer), I (ledger).
// Tolerance: bitwise for chunks and restore; one layer of mass; remainder 1e-4 of the throughput
// (given
//   in I for dt <= 1e-5; the bookkeeping is second order and reaches 5e-6 here).
// Seconds: 6
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"
#include "tests/support/shipped_scenes.h"
#include "worker/dem/records.h"
#include "worker/scene/chute.h"
#include "worker/scene/chute_plan.h"
#include "worker/scene/chute_simulation.h"

namespace granary::tests {
namespace {

v1::Scene short_chute() {
  return shipped_scene(
      "chute_small",
      {{"chute.duration_s", "0.12"}, {"chute.sample_start_s", "0.06"}, {"chute.length_m", "0.04"}});
}

std::string hash_of(const core::Simulation& simulation) {
  return core::hash_columns(simulation.physical_state());
}

constexpr std::uint64_t kNoLimit = std::uint64_t{1} << 40;

TEST(ChuteRun, chunks_do_not_change_a_bit) {
  const auto whole = scene::make_chute(short_chute());
  EXPECT_EQ(whole->advance(1, kNoLimit).status, core::AdvanceStatus::finished);
  const auto pieces = scene::make_chute(short_chute());
  std::uint64_t chunk = 1;
  while (pieces->advance(1, chunk).status == core::AdvanceStatus::advanced) {
    chunk = chunk * 7 % 1013;
  }
  EXPECT_EQ(hash_of(*whole), hash_of(*pieces));
  EXPECT_EQ(whole->progress().steps, pieces->progress().steps);
}

TEST(ChuteRun, restored_run_goes_on_bitwise) {
  const auto whole = scene::make_chute(short_chute());
  whole->advance(0.0731, kNoLimit);
  const core::State state = whole->snapshot();
  whole->advance(1, kNoLimit);
  const auto resumed = scene::make_chute(short_chute());
  resumed->restore(state);
  EXPECT_EQ(resumed->advance(1, kNoLimit).status, core::AdvanceStatus::finished);
  EXPECT_EQ(hash_of(*whole), hash_of(*resumed));
  const core::Observation expected = whole->observe();
  const core::Observation actual = resumed->observe();
  for (std::size_t k = 0; k < expected.values.size(); ++k) {
    EXPECT_EQ(expected.values[k].value, actual.values[k].value) << expected.values[k].name;
  }
  EXPECT_EQ(whole->ledger().remainder_j(), resumed->ledger().remainder_j());
}

TEST(ChuteRun, seeds_tell_replicates_apart) {
  v1::Scene other = short_chute();
  other.set_seed(other.seed() + 1);
  const auto one = scene::make_chute(short_chute());
  const auto two = scene::make_chute(other);
  one->advance(0.05, kNoLimit);
  two->advance(0.05, kNoLimit);
  EXPECT_NE(hash_of(*one), hash_of(*two));
}

TEST(ChuteRun, inlet_delivers_the_mass_flow_to_one_layer) {
  const Result<scene::ChutePlan> plan = scene::plan_chute(short_chute());
  const dem::LatticeFeed feed(*plan->feed);
  const double grain_mass = plan->engine.classes[0].mass();
  const double layer_mass = static_cast<double>(feed.layer_size(0)) * grain_mass;
  scene::ChuteSimulation simulation(*plan, nullptr);
  double left = 0;
  for (int k = 1; k <= 12; ++k) {
    simulation.advance(0.01 * k, kNoLimit);
    double inside = 0;
    const auto views = simulation.frame();
    const auto* position = static_cast<const double*>(views[0].data);
    for (std::size_t row = 0; row < views[0].rows; ++row) {
      if (position[3 * row] >= 0) inside += grain_mass;
    }
    const core::Table log = simulation.observe().fields.back();
    // Grains that left since the last frame are in no table yet; frames are 10 ms apart as are
    // these.
    left = static_cast<double>(log.columns[0].rows) * grain_mass;
    const double delivered = 0.4 * simulation.progress().time_s;
    EXPECT_NEAR(inside + left, delivered, 1.6 * layer_mass) << simulation.progress().time_s;
  }
}

TEST(ChuteRun, energy_ledger_closes) {
  Result<scene::ChutePlan> plan = scene::plan_chute(short_chute());
  scene::ChuteSimulation simulation(*plan, nullptr);
  simulation.advance(1, kNoLimit);
  EXPECT_LT(simulation.ledger().remainder_ratio(), 1e-4);
  EXPECT_GT(simulation.ledger()[core::EnergyChannel::friction], 0);
  EXPECT_GT(simulation.ledger()[core::EnergyChannel::normal_damping], 0);
  EXPECT_LT(simulation.ledger()[core::EnergyChannel::inlet], 0);
}

TEST(ChuteRun, energy_ledger_shows_a_force_it_does_not_know) {
  Result<scene::ChutePlan> plan = scene::plan_chute(short_chute());
  scene::ChuteSimulation simulation(*plan, nullptr);
  simulation.advance(0.05, kNoLimit);
  core::State state = simulation.snapshot();
  for (core::Column& column : state.columns) {
    if (column.name != "dem.motion") continue;
    auto* grains = reinterpret_cast<dem::GrainMotion*>(column.bytes.data());
    for (std::size_t k = 0; k < column.rows; ++k) {
      for (double& component : grains[k].velocity) component *= 1.05;
    }
  }
  simulation.restore(state);
  simulation.advance(1, kNoLimit);
  EXPECT_GT(simulation.ledger().remainder_ratio(), 1e-3);
}

// The ledger closes in a rotating chute too, in either frame.
TEST(ChuteRun, energy_ledger_closes_in_both_frames) {
  for (const char* frame : {"COROTATING", "INERTIAL"}) {
    v1::Scene scene = shipped_scene("chute_small", {{"chute.duration_s", "0.08"},
                                                    {"chute.sample_start_s", "0.06"},
                                                    {"chute.length_m", "0.04"},
                                                    {"chute.rotation_rpm", "60"},
                                                    {"chute.frame", frame}});
    Result<scene::ChutePlan> plan = scene::plan_chute(scene);
    scene::ChuteSimulation simulation(*plan, nullptr);
    simulation.advance(1, kNoLimit);
    EXPECT_LT(simulation.ledger().remainder_ratio(), 1e-4) << frame;
  }
}

TEST(ChuteRun, filling_settles_and_can_be_shared) {
  const v1::Scene scene = shipped_scene("chute_dense", {{"chute.length_m", "0.04"},
                                                        {"chute.initial_count", "600"},
                                                        {"chute.duration_s", "0.02"},
                                                        {"chute.sample_start_s", "0.01"}});
  const auto fills = scene::make_chute(scene);
  EXPECT_LT(fills->progress().time_s, 0);
  EXPECT_FALSE(fills->stored_filling().has_value());
  fills->advance(1, kNoLimit);
  ASSERT_TRUE(fills->stored_filling().has_value());
  const core::State filling = *fills->stored_filling();
  const auto reuses = scene::make_chute(scene, &filling);
  reuses->advance(1, kNoLimit);
  EXPECT_EQ(hash_of(*fills), hash_of(*reuses));
  EXPECT_LT(reuses->progress().steps, fills->progress().steps);
}

TEST(ChuteRun, filling_restores_bitwise) {
  const v1::Scene scene = shipped_scene("chute_dense", {{"chute.length_m", "0.02"},
                                                        {"chute.initial_count", "150"},
                                                        {"chute.duration_s", "0.02"},
                                                        {"chute.sample_start_s", "0.01"}});
  const auto whole = scene::make_chute(scene);
  whole->advance(-0.1, kNoLimit);
  const auto resumed = scene::make_chute(scene);
  resumed->restore(whole->snapshot());
  whole->advance(1, kNoLimit);
  resumed->advance(1, kNoLimit);
  EXPECT_EQ(hash_of(*whole), hash_of(*resumed));
}

}  // namespace
}  // namespace granary::tests
