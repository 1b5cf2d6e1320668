#include "proto/contract/scene_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/contract/field_path.h"

namespace granary {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kScene = R"(# a bucket
discharge {
  particles { count: 200 diameter_min_m: 0.01 density_kg_per_m3: 2200 }
  friction_pp_deg: 40
  friction_pw_deg: 40
  rotation_rad_per_s: 10.5
}
)";

std::string error_of(std::string text, const std::string& from, const std::string& to,
                     std::vector<FieldSetting> settings = {}) {
  const auto where = text.find(from);
  EXPECT_NE(where, std::string::npos);
  text.replace(where, from.size(), to);
  auto scene = load_scene(text, "bucket.txtpb", settings);
  EXPECT_FALSE(scene.ok()) << "accepted: " << text;
  return scene.ok() ? "" : scene.error().message;
}

TEST(SceneText, reads_both_notations_to_the_same_scene) {
  auto text = load_scene(kScene, "a", {});
  ASSERT_TRUE(text.ok()) << text.error().message;
  auto json = load_scene(scene_to_json(*text), "b", {});
  ASSERT_TRUE(json.ok()) << json.error().message;
  EXPECT_EQ(text->SerializeAsString(), json->SerializeAsString());
}

TEST(SceneText, unknown_key_gets_line_path_and_nearest_name) {
  EXPECT_THAT(error_of(kScene, "friction_pp_deg", "fricton_pp_deg"),
              AllOf(HasSubstr("bucket.txtpb:4:"), HasSubstr("discharge.fricton_pp_deg"),
                    HasSubstr("did you mean 'friction_pp_deg'"), Not(HasSubstr("\n"))));
}

TEST(SceneText, wrong_unit_is_an_unknown_key_with_the_right_one_near) {
  EXPECT_THAT(error_of(kScene, "diameter_min_m: 0.01", "diameter_min_mm: 10"),
              AllOf(HasSubstr(":3:"), HasSubstr("did you mean 'diameter_min_m'")));
}

TEST(SceneText, wrong_type_names_the_line) {
  EXPECT_THAT(error_of(kScene, "count: 200", "count: \"many\""), HasSubstr("bucket.txtpb:3:"));
}

TEST(SceneText, out_of_range_names_line_field_value_and_range) {
  EXPECT_THAT(error_of(kScene, "diameter_min_m: 0.01", "diameter_min_m: -0.01"),
              AllOf(HasSubstr("bucket.txtpb:3:"), HasSubstr("discharge.particles.diameter_min_m"),
                    HasSubstr("-0.01"), HasSubstr("> 0 and <= 1")));
  EXPECT_THAT(error_of(kScene, "count: 200", "count: 0"),
              AllOf(HasSubstr("count"), HasSubstr(">= 1")));
}

TEST(SceneText, nan_and_infinity_are_refused) {
  EXPECT_THAT(error_of(kScene, "rotation_rad_per_s: 10.5", "rotation_rad_per_s: nan"),
              AllOf(HasSubstr(":6:"), HasSubstr("not a finite number")));
  EXPECT_THAT(error_of(kScene, "friction_pp_deg: 40", "friction_pp_deg: inf"), HasSubstr("finite"));
}

TEST(SceneText, bucket_narrower_than_a_disk_is_refused) {
  EXPECT_THAT(
      error_of(kScene, "friction_pp_deg: 40", "bucket { tip_x_m: -0.009 } friction_pp_deg: 40"),
      AllOf(HasSubstr("bucket.tip_x_m"), HasSubstr("0.015")));
}

TEST(SceneText, missing_required_field_is_named) {
  EXPECT_THAT(error_of(kScene, "friction_pw_deg: 40", ""),
              AllOf(HasSubstr("discharge.friction_pw_deg"), HasSubstr("missing")));
  EXPECT_THAT(error_of(kScene, "rotation_rad_per_s: 10.5", ""), HasSubstr("rotation_rad_per_s"));
}

TEST(SceneText, json_errors_name_line_and_path) {
  auto scene = load_scene("{\"discharge\": {\n \"particles\": {\"count\": -3}}}", "a.json", {});
  ASSERT_FALSE(scene.ok());
  EXPECT_THAT(scene.error().message,
              AllOf(HasSubstr("a.json:2:"), HasSubstr("discharge.particles.count")));
  auto broken = load_scene("{\"discharge\": {\n \"particles\": }", "a.json", {});
  EXPECT_THAT(broken.error().message, HasSubstr("a.json:2:"));
}

TEST(SceneText, a_json_number_beyond_a_double_is_refused) {
  const auto scene = load_scene(R"({"seed": 1, "discharge": {"run_up_m": 1e30801}})", "s.json", {});
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().message, "s.json: a number in it is beyond the range of a double (1.8e308)");
}

// Escapes make bytes that no message may carry out of harmless ones.
TEST(SceneText, text_that_is_not_utf8_is_refused_with_its_field) {
  for (const char* bad : {"\\xff", "\\xc0\\x80", "\\xed\\xa0\\x80", "\\xe2\\x82"}) {
    const auto scene = load_scene("name: \"" + std::string(bad) + "\"\ndischarge {}", "s.txtpb", {});
    ASSERT_FALSE(scene.ok()) << bad;
    EXPECT_EQ(scene.error().message, "s.txtpb:1: name: is not valid UTF-8 text");
  }
  EXPECT_FALSE(load_scene("discharge {}", "s.txtpb", std::vector<FieldSetting>{{"name", "\xff"}}).ok());
  EXPECT_TRUE(parse_scene("name: \"K\xc3\xb6rner \xe2\x82\xac \xf0\x9f\x8c\xbe\"", "s.txtpb").ok());
}

// Found by fuzzing: a key may hold what would break the line.
TEST(SceneText, errors_are_one_line_whatever_the_keys_hold) {
  const auto scene = load_scene("{\"di\\n: 20, 0.01od\": \"3\"}", "scene.json", {});
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().message.find('\n'), std::string::npos) << scene.error().message;
  EXPECT_THAT(scene.error().message, HasSubstr("di?: 20"));
}

TEST(SetField, takes_paths_indices_and_bare_enums) {
  v1::Scene scene;
  EXPECT_TRUE(set_field(scene, "chute.particles[0].diameter_m", "0.003").ok());
  EXPECT_TRUE(set_field(scene, "effects.gas", "off").ok());
  EXPECT_TRUE(set_field(scene, "chute.gas.grid", "16,15,150").ok());
  EXPECT_EQ(scene.chute().particles(0).diameter_m(), 0.003);
  EXPECT_EQ(scene.effects().gas(), v1::Effects::OFF);
  EXPECT_EQ(scene.chute().gas().grid_size(), 3);
}

TEST(SetField, refuses_what_it_does_not_know) {
  v1::Scene scene;
  EXPECT_THAT(set_field(scene, "discharge.rotation_rpm", "3").error().message,
              HasSubstr("rotation_rad_per_s"));
  EXPECT_FALSE(set_field(scene, "chute.particles[1].diameter_m", "0.003").ok());
  EXPECT_FALSE(set_field(scene, "chute.particles[x].diameter_m", "0.003").ok());
  EXPECT_FALSE(set_field(scene, "discharge", "3").ok());
  EXPECT_FALSE(set_field(scene, "", "3").ok());
  EXPECT_THAT(set_field(scene, "effects.gas", "maybe").error().message, HasSubstr("AUTO, ON, OFF"));
}

}  // namespace
}  // namespace granary
