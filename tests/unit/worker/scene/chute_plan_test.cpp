// Scenes that cannot run are refused with the field and the limit; those that can become what they say.
#include "worker/scene/chute_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shipped_scenes.h"
#include "worker/scene/chute.h"

namespace granary::scene {
namespace {

using ::testing::HasSubstr;
using tests::shipped_scene;

void expect_refused(const v1::Scene& scene, const std::string& path, const std::string& limit) {
  const Result<ChutePlan> plan = plan_chute(scene);
  ASSERT_FALSE(plan.ok());
  EXPECT_EQ(plan.error().field_path, path);
  EXPECT_THAT(plan.error().message, HasSubstr(limit));
  EXPECT_THROW(make_chute(scene), std::invalid_argument);
}

TEST(ChutePlan, base_case_becomes_the_papers_numbers) {
  const Result<ChutePlan> plan = plan_chute(shipped_scene("chute_base_30deg", {{"chute.rotation_rpm", "16"}}));
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->engine.walls.size(), 3U);
  EXPECT_NEAR(norm(plan->engine.motion.gravity), 9.81, 1e-12);
  EXPECT_NEAR(norm(plan->engine.motion.omega), 1.6755161, 1e-7);
  // Clockwise seen from above: along gravity, so Coriolis pushes downstream motion to +y.
  EXPECT_GT(dot(plan->engine.motion.omega, plan->engine.motion.gravity), 0);
  EXPECT_GT((-2 * cross(plan->engine.motion.omega, core::Vec3{1, 0, 0})).y, 0);
  EXPECT_EQ(plan->engine.outlet_x, 0.9);
  ASSERT_TRUE(plan->feed.has_value());
  EXPECT_EQ(plan->feed->mass_flow, 1.6);
}

TEST(ChutePlan, every_shipped_chute_is_accepted) {
  for (const char* name : {"chute_small", "chute_base_30deg", "chute_base_40deg",
                           "chute_base_measured_friction", "chute_mixture", "chute_dense"}) {
    const Result<ChutePlan> plan = plan_chute(shipped_scene(name));
    EXPECT_TRUE(plan.ok()) << name << ": " << (plan.ok() ? "" : plan.error().message);
  }
}

TEST(ChutePlan, unstable_time_step_is_refused) {
  v1::Scene scene = shipped_scene("chute_small");
  scene.mutable_chute()->set_time_step_s(2e-4);
  expect_refused(scene, "chute.time_step_s", "0.0001096");
}

// Rules of the contract hold for scenes that never saw it (the rest: Resolve.chutes_that_cannot_run...).
TEST(ChutePlan, walls_closer_than_a_grain_are_refused) {
  v1::Scene scene = shipped_scene("chute_small");
  auto* plane = scene.mutable_chute()->add_planes();
  for (const double value : {0.0, 0.0, 0.002}) plane->add_point_m(value);
  for (const double value : {0.0, 0.0, -1.0}) plane->add_normal(value);
  expect_refused(scene, "chute.planes", "one grain diameter = 0.003 m");
}

TEST(ChutePlan, negative_friction_is_refused) {
  v1::Scene scene = shipped_scene("chute_small");
  scene.mutable_chute()->mutable_contact_pw()->set_friction_coefficient(-0.1);
  expect_refused(scene, "chute.contact_pw.friction_coefficient", ">= 0");
}

TEST(ChutePlan, laboratory_spin_enters_with_minus_omega) {
  const Result<ChutePlan> plan =
      plan_chute(shipped_scene("chute_base_30deg", {{"chute.rotation_rpm", "8"},
                                                    {"chute.inlet.spin", "LABORATORY"}}));
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->feed->spin, -plan->engine.motion.omega);
}

TEST(ChutePlan, rotating_frame_off_means_no_rotation) {
  const Result<ChutePlan> plan = plan_chute(shipped_scene(
      "chute_base_30deg", {{"chute.rotation_rpm", "8"}, {"effects.rotating_frame", "OFF"}}));
  ASSERT_TRUE(plan.ok());
  EXPECT_FALSE(plan->engine.motion.rotates());
}

}  // namespace
}  // namespace granary::scene
