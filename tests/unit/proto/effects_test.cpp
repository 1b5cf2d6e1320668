#include "proto/contract/effects.h"

#include <gtest/gtest.h>

#include "tests/support/shipped_scenes.h"

namespace granary {
namespace {

std::map<std::string, v1::EffectReport> effects_of(const std::string& rpm,
                                                   const std::string& target) {
  return decide_effects(
      tests::shipped_scene("chute_base_30deg", {{"chute.rotation_rpm", rpm},
                                                {"effects.gas", "AUTO"},
                                                {"effects.rotating_frame", "AUTO"},
                                                {"accuracy.target", target},
                                                {"accuracy.observable", "exit_speed_m_per_s"}}));
}

// Resolved scenes carry ON and OFF; what AUTO decides is asked of the scene as written.
v1::Scene as_written(const std::string& rpm, const std::string& target) {
  v1::Scene scene = tests::shipped_scene("chute_base_30deg", {{"chute.rotation_rpm", rpm}});
  scene.clear_effects();
  scene.mutable_accuracy()->set_target(std::stod(target));
  scene.mutable_accuracy()->set_observable("exit_speed_m_per_s");
  return scene;
}

TEST(Effects, rotating_chute_keeps_its_frame_and_drops_the_gas_at_five_percent) {
  const auto effects = decide_effects(as_written("16", "0.05"));
  EXPECT_TRUE(effects.at("rotating_frame").on());
  EXPECT_NEAR(effects.at("rotating_frame").number(), 39, 2);  // deg of tilt, PHYSICS section C
  EXPECT_FALSE(effects.at("gas").on());
  EXPECT_LT(effects.at("gas").number(), effects.at("gas").threshold());
  EXPECT_EQ(effects.at("gas").chosen_by(), "auto");
  EXPECT_EQ(effects.at("gas").omitted_error(), effects.at("gas").number());
}

TEST(Effects, chute_at_rest_needs_no_rotating_frame_and_loses_nothing) {
  const auto effects = decide_effects(as_written("0", "0.05"));
  EXPECT_FALSE(effects.at("rotating_frame").on());
  EXPECT_EQ(effects.at("rotating_frame").omitted_error(), 0);
}

TEST(Effects, air_on_flying_disks_is_judged_by_the_accuracy_asked_for) {
  v1::Scene scene = tests::shipped_scene("discharge_small", {{"accuracy.observable", "f1_m"}});
  scene.clear_effects();
  const double bound = decide_effects(scene).at("gas").number();
  for (const double target : {0.5 * bound, 2 * bound}) {
    scene.mutable_accuracy()->set_target(target);
    const v1::EffectReport gas = decide_effects(scene).at("gas");
    EXPECT_EQ(gas.threshold(), target);
    EXPECT_EQ(gas.on(), target < bound);
    EXPECT_EQ(gas.omitted_error(), gas.on() ? 0 : bound);
  }
}

TEST(Effects, resolved_scene_says_what_runs) {
  const auto effects = effects_of("16", "0.05");
  EXPECT_TRUE(effects.at("rotating_frame").on());
  EXPECT_FALSE(effects.at("gas").on());
}

}  // namespace
}  // namespace granary
