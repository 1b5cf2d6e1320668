// Bad input: one line on stderr that names line, field, value and range; exit 2; nothing queued.
#include <fcntl.h>
#include <unistd.h>

#include <filesystem>

#include "tests/support/client_fixture.h"

namespace granary::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class ClientSceneInput : public ClientTest {
 protected:
  // The small scene with `from` replaced by `to`, behind a good one: neither may be queued.
  std::string refusal_of(const std::string& from, const std::string& to) {
    std::string text = kSmallScene;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return refusal_of_file(scratch_.write("bad.txtpb", text));
  }
  std::string refusal_of_file(const std::string& file) {
    const Outputs outputs = granary({"submit", scene(), file});
    EXPECT_EQ(outputs.exit_code, 2);
    EXPECT_THAT(outputs.out, IsEmpty());
    EXPECT_THAT(outputs.err, IsOneErrorLine());
    EXPECT_THAT(jobs().submissions(), IsEmpty());
    return outputs.err;
  }
};

TEST_F(ClientSceneInput, unknown_key_is_refused_with_line_and_nearest_name) {
  const std::string error = refusal_of("friction_pp_deg", "friction_p_deg");
  EXPECT_THAT(error, HasSubstr("bad.txtpb:3"));
  EXPECT_THAT(error, HasSubstr("friction_p_deg"));
  EXPECT_THAT(error, HasSubstr("did you mean"));
}

TEST_F(ClientSceneInput, wrong_type_is_refused_with_its_line) {
  EXPECT_THAT(refusal_of("count: 20", "count: many"), HasSubstr("bad.txtpb:2"));
}

TEST_F(ClientSceneInput, impossible_values_are_refused_with_line_field_and_range) {
  for (const auto& [from, to, field] : std::vector<std::array<const char*, 3>>{
           {"diameter_min_m: 0.01", "diameter_min_m: -0.01", "discharge.particles.diameter_min_m"},
           {"count: 20", "count: 0", "discharge.particles.count"},
           {"friction_pp_deg: 30", "friction_pp_deg: nan", "discharge.friction_pp_deg"},
           {"rotation_rad_per_s: 10.5", "rotation_rad_per_s: inf",
            "discharge.rotation_rad_per_s"}}) {
    const std::string error = refusal_of(from, to);
    EXPECT_THAT(error, HasSubstr("bad.txtpb:"));
    EXPECT_THAT(error, HasSubstr(field));
    EXPECT_THAT(error, HasSubstr("must be"));
  }
}

TEST_F(ClientSceneInput, bucket_narrower_than_a_disk_is_refused) {
  const std::string error =
      refusal_of("friction_pw_deg: 20", "friction_pw_deg: 20\n  bucket { tip_x_m: -0.012 }");
  EXPECT_THAT(error, HasSubstr("bad.txtpb:5"));
  EXPECT_THAT(error, HasSubstr("discharge.bucket.tip_x_m"));
}

TEST_F(ClientSceneInput, bad_set_is_refused_with_its_path) {
  const Outputs outputs = granary({"submit", scene(), "--set", "discharge.friction_pp_dg=3"});
  EXPECT_EQ(outputs.exit_code, 2);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
  EXPECT_THAT(outputs.err, HasSubstr("did you mean 'friction_pp_deg'"));
  EXPECT_EQ(granary({"submit", scene(), "--set", "novalue"}).exit_code, 2);
  EXPECT_THAT(jobs().submissions(), IsEmpty());
}

TEST_F(ClientSceneInput, gigabyte_file_is_refused_unread) {
  const std::string file = scratch_.file("huge.txtpb");
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_EQ(ftruncate(fd, 1L << 30), 0);  // sparse: takes no room
  close(fd);
  EXPECT_THAT(refusal_of_file(file), HasSubstr("1073741824 bytes"));
}

TEST_F(ClientSceneInput, endless_input_is_refused_at_the_limit) {
  EXPECT_THAT(refusal_of_file("/dev/zero"), HasSubstr("at most 16777216 bytes"));
}

TEST_F(ClientSceneInput, missing_file_directory_and_empty_file_are_refused) {
  EXPECT_THAT(refusal_of_file(scratch_.file("none.txtpb")), HasSubstr("No such file"));
  EXPECT_THAT(refusal_of_file(scratch_.path()), HasSubstr("is a directory"));
  refusal_of_file(scratch_.write("empty.txtpb", ""));
}

TEST_F(ClientSceneInput, dash_reads_the_scene_from_stdin_once) {
  EXPECT_EQ(granary({"submit", "-"}, kSmallScene).out, "jobs/new1\n");
  EXPECT_EQ(granary({"submit", "-", "-"}, kSmallScene).exit_code, 2);
  const Outputs bad = granary({"submit", "-"}, "discharge { }");
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.err, HasSubstr("<stdin>"));
}

TEST_F(ClientSceneInput, bad_time_limit_or_tag_is_refused_before_anything_is_sent) {
  for (const auto& option : std::vector<std::vector<std::string>>{
           {"--time-limit", "soon"}, {"--tag", "novalue"}, {"--priority", "high"}}) {
    std::vector<std::string> arguments{"submit", scene()};
    arguments.insert(arguments.end(), option.begin(), option.end());
    const Outputs outputs = granary(arguments);
    EXPECT_EQ(outputs.exit_code, 2) << option[0];
    EXPECT_THAT(outputs.err, IsOneErrorLine());
  }
  EXPECT_THAT(jobs().submissions(), IsEmpty());
}

}  // namespace
}  // namespace granary::test
