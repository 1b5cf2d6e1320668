// Effects of a discharge: one kernel per combination, the others refused before anything is queued;
// off means not executed, and not felt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "proto/contract/contact_effects.h"
#include "proto/contract/resolve.h"
#include "tests/support/shipped_scenes.h"
#include "worker/dda/contact_effects.h"
#include "worker/scene/discharge.h"

namespace granary::scene {
namespace {

using testing::HasSubstr;
using tests::shipped_scene;

struct Ran {
  std::string hash;
  std::map<std::string, std::uint64_t> evaluations;
  double remainder;
};

// Filling and the first part of the rotation of discharge_small.
Ran run_small(std::vector<FieldSetting> settings) {
  settings.emplace_back("discharge.end_angle_deg", "40");
  const auto simulation = make_discharge(shipped_scene("discharge_small", settings));
  while (simulation->advance(1e9, 1000).status == core::AdvanceStatus::advanced) {
  }
  Ran run{
      core::hash_columns(simulation->physical_state()), {}, simulation->ledger().remainder_ratio()};
  for (const auto& [name, count] : simulation->observe().effect_evaluations)
    run.evaluations[name] = count;
  return run;
}

TEST(DischargeEffects, contract_and_engine_hold_the_same_table) {
  const auto combinations = contact_combinations();
  ASSERT_EQ(combinations.size(), dda::kCombinationCount);
  for (std::size_t k = 0; k < combinations.size(); ++k) {
    const ContactEffectSet& c = combinations[k];
    EXPECT_EQ(dda::kContactCombinations[k],
              (dda::ContactEffects{c.particle_rotation, c.tangential_history, c.cohesion,
                                   c.rolling_friction}))
        << to_string(c);
  }
}

// An effect that is on with a coefficient of zero must not be felt: the kernel without it gives the
// same bits.
TEST(DischargeEffects, off_is_bitwise_the_trajectory_without_the_effect) {
  const Ran plain = run_small({});
  for (const std::string effect : {"cohesion", "rolling_friction"}) {
    const Ran with = run_small({{"effects." + effect, "ON"}});
    EXPECT_GT(with.evaluations.at(effect), 0u);
    EXPECT_EQ(with.hash, plain.hash) << effect;
    EXPECT_EQ(plain.evaluations.at(effect), 0u);
  }
  EXPECT_GT(plain.evaluations.at("tangential_history"), 0u);
  EXPECT_GT(plain.evaluations.at("particle_rotation"), 0u);
}

TEST(DischargeEffects, off_is_counted_zero_times_whatever_the_coefficient) {
  const Ran plain = run_small({});
  const std::map<std::string, std::string> coefficient = {
      {"cohesion", "discharge.cohesion_n_per_m"},
      {"rolling_friction", "discharge.rolling_friction_coefficient"}};
  for (const auto& [effect, path] : coefficient) {
    const Ran off = run_small({{"effects." + effect, "OFF"}, {path, "0.2"}});
    EXPECT_EQ(off.evaluations.at(effect), 0u);
    EXPECT_EQ(off.hash, plain.hash) << effect;
    const Ran on = run_small({{path, "0.2"}});
    EXPECT_GT(on.evaluations.at(effect), 0u);
    EXPECT_NE(on.hash, plain.hash) << effect;
    EXPECT_LT(on.remainder, 1e-3) << effect;
  }
  for (const std::string effect : {"tangential_history", "particle_rotation"}) {
    const Ran off = run_small({{"effects." + effect, "OFF"}});
    EXPECT_EQ(off.evaluations.at(effect), 0u);
    EXPECT_NE(off.hash, plain.hash) << effect;
    EXPECT_LT(off.remainder, 1e-3) << effect;
  }
}

std::string refusal(std::vector<FieldSetting> settings) {
  std::ifstream file(std::string(GRANARY_SCENES) + "/discharge_small.txtpb");
  std::stringstream text;
  text << file.rdbuf();
  const auto scene = load_scene(text.str(), "discharge_small", settings);
  EXPECT_TRUE(scene);
  const auto resolved = resolve(*scene);
  return resolved ? "" : resolved.error().field_path + " | " + resolved.error().message;
}

TEST(DischargeEffects, every_combination_is_run_or_refused_with_the_valid_ones_listed) {
  for (int bits = 0; bits < 16; ++bits) {
    const ContactEffectSet wanted{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0,
                                  (bits & 8) != 0};
    const auto mode = [&](bool on) { return std::string(on ? "ON" : "OFF"); };
    const std::string message =
        refusal({{"effects.particle_rotation", mode(wanted.particle_rotation)},
                 {"effects.tangential_history", mode(wanted.tangential_history)},
                 {"effects.cohesion", mode(wanted.cohesion)},
                 {"effects.rolling_friction", mode(wanted.rolling_friction)}});
    const auto table = contact_combinations();
    const bool known = std::find(table.begin(), table.end(), wanted) != table.end();
    EXPECT_EQ(message.empty(), known) << message;
    if (known) continue;
    EXPECT_THAT(message, HasSubstr("effects | effects: " + to_string(wanted)));
    EXPECT_THAT(message, HasSubstr("particle_rotation + tangential_history + cohesion;"));
  }
}

TEST(DischargeEffects, open_close_and_newmark_refuse_the_laws_they_do_not_know) {
  for (const FieldSetting& solver : {FieldSetting{"discharge.solver.method", "OPEN_CLOSE"},
                                    FieldSetting{"discharge.solver.integrator", "NEWMARK_DDA"}}) {
    EXPECT_EQ(refusal({solver}), "");
    EXPECT_EQ(refusal({solver, {"effects.particle_rotation", "OFF"}}), "");
    EXPECT_EQ(refusal({solver, {"discharge.damping_per_s", "1"}}), "");
    EXPECT_THAT(refusal({solver, {"discharge.cohesion_n_per_m", "0.1"}}),
                HasSubstr("must be one of"));
    EXPECT_EQ(refusal({solver, {"discharge.cohesion_n_per_m", "0.1"}, {"effects.cohesion", "OFF"}}),
              "");
    EXPECT_THAT(refusal({solver, {"discharge.rolling_friction_coefficient", "0.1"}}),
                HasSubstr("rolling_friction is not built"));
  }
  EXPECT_THAT(refusal({{"discharge.solver.integrator", "NEWMARK_DDA"},
                       {"discharge.normal_restitution", "0.5"}}),
              HasSubstr("discharge.normal_restitution"));
}

TEST(DischargeEffects, solvers_without_small_steps_count_the_laws_they_run) {
  const std::vector<FieldSetting> newmark = {{"discharge.solver.integrator", "NEWMARK_DDA"},
                                             {"discharge.time_step_s", "2e-5"}};
  const Ran on = run_small(newmark);
  EXPECT_EQ(on.evaluations.at("cohesion"), 0u);
  EXPECT_EQ(on.evaluations.at("rolling_friction"), 0u);
  EXPECT_GT(on.evaluations.at("particle_rotation"), 0u);
}

}  // namespace
}  // namespace granary::scene
