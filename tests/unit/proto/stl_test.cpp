#include "proto/contract/stl.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>

#include "proto/contract/scene_meshes.h"
#include "proto/contract/scene_text.h"
#include "tests/support/temporary_directory.h"

namespace granary {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string binary(const std::vector<std::array<float, 9>>& triangles, std::uint32_t promised) {
  std::string bytes(80, 'b');
  bytes.append(reinterpret_cast<const char*>(&promised), sizeof promised);
  for (const auto& corners : triangles) {
    bytes.append(12, '\0');
    bytes.append(reinterpret_cast<const char*>(corners.data()), 36);
    bytes.append(2, '\0');
  }
  return bytes;
}

const std::array<float, 9> kCorner = {0, 0, 0, 2, 0, 0, 0, 3, 0.5F};

std::string ascii(const std::string& third_corner) {
  return "solid of a test\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 2.0 0 0\n"
         "   vertex " +
         third_corner + "\n  endloop\n endfacet\nendsolid\n";
}

TEST(Stl, ascii_and_binary_give_the_same_triangles) {
  const auto one = parse_stl(binary({kCorner}, 1), "b.stl");
  const auto other = parse_stl(ascii("0 3e0 +0.5"), "a.stl");
  ASSERT_TRUE(one.ok()) << one.error().message;
  ASSERT_TRUE(other.ok()) << other.error().message;
  EXPECT_EQ(*one, *other);
  EXPECT_EQ((*one)[0], (TriangleCorners{0, 0, 0, 2, 0, 0, 0, 3, 0.5}));
}

TEST(Stl, binary_file_may_begin_with_solid) {
  std::string bytes = binary({kCorner, kCorner}, 2);
  bytes.replace(0, 6, "solid ");
  const auto triangles = parse_stl(bytes, "b.stl");
  ASSERT_TRUE(triangles.ok()) << triangles.error().message;
  EXPECT_EQ(triangles->size(), 2U);
}

TEST(Stl, bad_files_are_refused_with_one_line_that_says_where) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string whole = binary({kCorner, kCorner}, 2);
  const struct {
    std::string bytes;
    const char* why;
  } cases[] = {
      {"", "no STL file"},
      {"solid\nendsolid", "has 0 triangles, must be 1 to 20000"},
      {"solid", "line 1 ends the file where 'facet or endsolid' belongs"},
      {ascii("0 nan 0"), "the triangle of line 2 has a corner at nan"},
      {ascii("0 inf 0"), "must be a finite number"},
      {ascii("0 three 0"), "line 6 has 'three' where 'a number' belongs"},
      {ascii("4 0 0"), "line 2 has no area"},
      {ascii("0 3 0").substr(0, 80), "ends the file where"},
      {ascii("0 3 0") + "more", "line 10 has 'more' where 'solid' belongs"},
      {whole.substr(0, whole.size() - 1), "has 183 bytes, 2 triangles need 184"},
      {whole.substr(0, 60), "no STL file"},
      {binary({kCorner}, 0xffffffffU), "has 4294967295 triangles, must be 1 to 20000"},
      {binary({kCorner, {0, 0, 0, 1, 0, 0, 0, nan, 0}}, 2), "triangle 2 has a corner at nan"},
      {binary({{0, 0, 0, 1, 1, 1, 2, 2, 2}}, 1), "triangle 1 has no area"},
  };
  for (const auto& c : cases) {
    const auto triangles = parse_stl(c.bytes, "part.stl");
    ASSERT_FALSE(triangles.ok()) << c.why;
    EXPECT_THAT(triangles.error().message, HasSubstr(c.why));
    EXPECT_THAT(triangles.error().message, StartsWith("part.stl: "));
    EXPECT_EQ(triangles.error().message.find('\n'), std::string::npos);
  }
}

// Bytes cut and changed at random: triangles with an area, or one line.
TEST(Stl, hostile_bytes_give_sound_triangles_or_one_line) {
  const std::string seeds[] = {binary({kCorner, kCorner, kCorner}, 3), ascii("0 3 0")};
  std::mt19937 random(7);
  const auto below = [&](std::size_t limit) { return random() % limit; };
  int refused = 0;
  for (int k = 0; k < 4000; ++k) {
    std::string bytes = seeds[below(2)];
    if (below(3) == 0) bytes.resize(below(bytes.size() + 1));
    for (std::size_t changes = below(4); changes > 0 && !bytes.empty(); --changes) {
      bytes[below(bytes.size())] = static_cast<char>(below(256));
    }
    const auto triangles = parse_stl(bytes, "h.stl");
    if (!triangles) {
      ++refused;
      const std::string& line = triangles.error().message;
      EXPECT_THAT(line, StartsWith("h.stl: "));
      EXPECT_TRUE(
          std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; }));
      continue;
    }
    for (const TriangleCorners& corners : *triangles) {
      EXPECT_TRUE(has_area(corners));
      for (const double value : corners) EXPECT_TRUE(std::isfinite(value));
    }
  }
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 3900);
}

// ---------------------------------------------------------------------------- named by a scene

class SceneMeshes : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) {
    const std::string path = (folder_.path() / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  v1::Scene scene(const std::string& mesh) {
    return parse_scene("chute { meshes { " + mesh + " } }", "s")->scene;
  }
  std::string scene_file() const { return (folder_.path() / "s.txtpb").string(); }

  testing::TemporaryDirectory folder_;
};

TEST_F(SceneMeshes, become_triangles_in_metres) {
  write("part.stl", binary({kCorner}, 1));
  v1::Scene named = scene("stl_file: \"part.stl\" unit_m: 0.001 offset_m: [1, 2, 3]");
  ASSERT_TRUE(inline_meshes(named, scene_file()).ok());
  EXPECT_EQ(named.chute().meshes_size(), 0);
  ASSERT_EQ(named.chute().triangles_size(), 1);
  const auto& v = named.chute().triangles(0).vertices_m();
  EXPECT_EQ(std::vector<double>(v.begin(), v.end()),
            (std::vector<double>{1, 2, 3, 1.002, 2, 3, 1, 2.003, 3.0005}));
}

TEST_F(SceneMeshes, missing_or_strange_files_are_refused_by_field) {
  write("bad.stl", ascii("nan 0 0"));
  const struct {
    const char* mesh;
    const char* why;
  } cases[] = {
      {"stl_file: \"none.stl\"", "is not there"},
      {"stl_file: \".\"", "is no regular file"},
      {"unit_m: 2", "is missing"},
      {"stl_file: \"bad.stl\"", "bad.stl: the triangle of line 2 has a corner at nan"},
  };
  for (const auto& c : cases) {
    v1::Scene named = scene(c.mesh);
    const Status status = inline_meshes(named, scene_file());
    ASSERT_FALSE(status.ok()) << c.why;
    EXPECT_EQ(status.error().field_path, "chute.meshes[0].stl_file");
    EXPECT_THAT(status.error().message, HasSubstr(c.why));
  }
}

}  // namespace
}  // namespace granary
