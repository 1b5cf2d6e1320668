#include "proto/contract/resolve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/contract/effects.h"
#include "proto/contract/field_path.h"
#include "proto/contract/scene_text.h"

namespace granary {
namespace {

v1::Scene bucket(const std::string& extra = "") {
  auto scene = load_scene(
      "discharge { particles { count: 700 diameter_min_m: 0.0035 diameter_max_m: 0.0045 "
      "density_kg_per_m3: 730 } friction_pp_deg: 25 friction_pw_deg: 34 "
      "rotation_rad_per_s: 8.9 " +
          extra + " }",
      "bucket", {});
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return *scene;
}

v1::Scene chute(const std::string& extra = "", const std::string& top = "") {
  auto scene = load_scene(
      "chute { inclination_deg: 30 duration_s: 6 particles { diameter_m: 0.003 density_kg_per_m3: "
      "2550 } "
      "contact_pp { normal_restitution: 0.97 tangential_restitution: 0.33 friction_coefficient: "
      "0.12 } "
      "contact_pw { normal_restitution: 0.95 tangential_restitution: 0.33 friction_coefficient: "
      "0.22 } "
      "inlet { mass_flow_kg_per_s: 1.6 sluice_height_m: 0.045 } " +
          extra + " } " + top,
      "chute", {});
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return *scene;
}

TEST(Resolve, says_who_chose_each_setting) {
  auto resolved = resolve(bucket());
  ASSERT_TRUE(resolved.ok()) << resolved.error().message;
  std::map<std::string, std::string> who;
  for (const auto& decision : resolved->decisions) who[decision.path()] = decision.chosen_by();
  EXPECT_EQ(who["discharge.rotation_rad_per_s"], "user");
  EXPECT_EQ(who["discharge.pulley_radius_m"], "default");
  EXPECT_EQ(who["discharge.solver.tolerance"], "auto");
  EXPECT_EQ(who["effects.gas"], "auto");
  EXPECT_EQ(resolved->scene.discharge().bucket().wall_height_m(), 0.4);
}

TEST(Resolve, is_idempotent) {
  auto once = resolve(chute());
  ASSERT_TRUE(once.ok());
  auto twice = resolve(once->scene);
  ASSERT_TRUE(twice.ok());
  EXPECT_EQ(job_key(once->scene), job_key(twice->scene));
}

TEST(Resolve, chute_step_is_the_base_case_of_a_42nd_of_the_contact_time) {
  auto resolved = resolve(chute());  // t_c = 4.218e-4 s (PHYSICS A1)
  ASSERT_TRUE(resolved.ok());
  EXPECT_NEAR(resolved->scene.chute().time_step_s(), 1.0e-5, 1e-12);
}

TEST(Resolve, refuses_a_step_beyond_the_stable_limit) {
  auto resolved = resolve(chute("time_step_s: 0.0005"));
  ASSERT_FALSE(resolved.ok());
  EXPECT_EQ(resolved.error().field_path, "chute.time_step_s");
  EXPECT_THAT(resolved.error().message, testing::HasSubstr("8.436e-05"));
}

TEST(JobKey, ignores_what_cannot_change_the_physics) {
  const std::string key = job_key(resolve(chute())->scene);
  EXPECT_EQ(job_key(resolve(chute("", "threads: 2 name: \"x\" output { frames: 7 }"))->scene), key);
  EXPECT_NE(job_key(resolve(chute("", "seed: 2"))->scene), key);
  EXPECT_NE(job_key(resolve(chute("rotation_rpm: 4"))->scene), key);
}

TEST(JobKey, an_explicit_default_is_the_same_job) {
  EXPECT_EQ(job_key(resolve(bucket())->scene),
            job_key(resolve(bucket("pulley_radius_m: 0.5"))->scene));
}

TEST(FillingKey, is_shared_by_a_speed_sweep_only) {
  const auto key = [](const v1::Scene& scene) { return filling_key(resolve(scene)->scene); };
  v1::Scene faster = bucket();
  faster.mutable_discharge()->set_rotation_rad_per_s(10);
  EXPECT_EQ(key(faster), key(bucket()));
  EXPECT_NE(key(bucket("bucket { tip_x_m: -0.3 }")), key(bucket()));
  EXPECT_EQ(key(chute()), "");
}

TEST(Effects, numbers_are_those_of_the_papers_base_case) {
  auto base = decide_effects(resolve(chute())->scene);
  EXPECT_FALSE(base["gas"].on());
  // min(G, B) of PHYSICS C: the momentum bound B ~ 0.003 is the smaller one.
  EXPECT_NEAR(base["gas"].number(), 1.2 * 0.08 * 0.045 * 2.354 / (2 * 1.6), 2e-4);
  EXPECT_FALSE(base["rotating_frame"].on());
  auto rotating = decide_effects(resolve(chute("rotation_rpm: 16"))->scene);
  EXPECT_TRUE(rotating["rotating_frame"].on());
  EXPECT_NEAR(rotating["rotating_frame"].number(), 39, 1);
}

TEST(Effects, terminal_velocity_of_3_mm_glass) {
  EXPECT_NEAR(terminal_velocity(0.003, 2550, 1.2, 1.81e-5, 9.81), 13.76, 0.02);  // PHYSICS A4
}

TEST(Effects, the_user_decides_over_auto) {
  auto scene = resolve(chute("rotation_rpm: 16", "effects { rotating_frame: OFF }"));
  ASSERT_TRUE(scene.ok());
  EXPECT_FALSE(scene->effects["rotating_frame"].on());
  EXPECT_EQ(scene->effects["rotating_frame"].chosen_by(), "user");
  auto gas = resolve(chute("", "effects { gas: ON }"));
  ASSERT_FALSE(gas.ok());
  EXPECT_EQ(gas.error().field_path, "effects.gas");
}

TEST(NearestName, gives_up_when_nothing_is_near) {
  EXPECT_EQ(nearest_name("frict", {"friction", "density"}), "friction");
  EXPECT_EQ(nearest_name("zzzzzz", {"friction", "density"}), "");
}

// Chutes that cannot run are refused before anything is queued, with the field and the limit.
TEST(Resolve, chutes_that_cannot_run_are_refused_with_the_limit) {
  const struct {
    const char* scene;
    const char* field;
    const char* limit;
  } cases[] = {
      {"time_step_s: 0.0002", "chute.time_step_s", "must be > 0 and <= 8.43"},
      {"width_m: 0.002", "chute.width_m", "must be >= 0.003"},
      {"planes { point_m: [0, 0, 0.002] normal: [0, 0, -1] }", "chute.planes",
       "must leave one grain diameter = 0.003 m"},
      {"planes { point_m: [0, 0, 0] normal: [0, 0, 0] }", "chute.planes[0].normal", "not be zero"},
      {"inlet { mass_flow_kg_per_s: 60 }", "chute.inlet.mass_flow_kg_per_s",
       "the lattice allows <= 5.586 m/s"},
      {"inlet { sluice_height_m: 0.002 }", "chute.inlet.sluice_height_m", "must be >= 0.003"},
      {"contact_pw { friction_coefficient: -0.1 }", "chute.contact_pw.friction_coefficient",
       "must be >= 0"},
      {"particles { diameter_m: 0.00005 density_kg_per_m3: 2550 mass_fraction: 0.5 }",
       "chute.particles", "1:60, must be within 1:50"},
      {"inlet { feed: HOPPER }", "chute.inlet.hopper_height_m", "is missing"},
      {"inlet { feed: HOPPER hopper_height_m: 0.1 hopper_opening_m: 0.002 }",
       "chute.inlet.hopper_opening_m", "must be >= 0.003 and <= 0.1"},
      {"inlet { feed: HOPPER hopper_height_m: 0.1 hopper_opening_m: 0.02 }",
       "chute.inlet.mass_flow_kg_per_s", "stands beside feed HOPPER"},
      {"triangles { vertices_m: [0, 0, 0, 1, 0, 0, 2, 0, 0] }", "chute.triangles[0].vertices_m",
       "has no area"},
      {"triangles { vertices_m: [0, 0, 0, 1, 0, 0] }", "chute.triangles[0].vertices_m",
       "needs 9 numbers"},
      {"meshes { stl_file: \"/etc/passwd\" }", "chute.meshes[0].stl_file", "carries chute.triangles"},
  };
  for (const auto& c : cases) {
    const auto extra = parse_scene("chute { " + std::string(c.scene) + " }", "extra");
    ASSERT_TRUE(extra.ok()) << extra.error().message;
    v1::Scene scene = chute();
    scene.MergeFrom(extra->scene);
    const auto resolved = resolve(scene);
    ASSERT_FALSE(resolved.ok()) << c.scene;
    EXPECT_EQ(resolved.error().field_path, c.field) << c.scene;
    EXPECT_THAT(resolved.error().message, ::testing::HasSubstr(c.limit));
    EXPECT_EQ(resolved.error().message.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace granary
