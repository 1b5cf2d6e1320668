// Claim: a chute whose walls come from an STL file is the chute made of planes, from the file to
// the
//   last bit of the run; the mesh of a job can be checkpointed; who has no file refuses.
// Method: chute_small, 0.03 m long, 0.05 s, floor and side walls once as planes, once as an ASCII
//   STL in millimetres; grains of both runs compared by id. Doubles, plain engine.
// Reference: the run between planes.
// Tolerance: 0.001 x millimetres and the plane's own coordinate differ by 1 ulp (1.4e-17 m at the
//   far side wall); in 50 ms of flow neighbours part by at most e in 2 ms (PHYSICS G), e^25 = 7e10:
//   1e-6 m. Mass flows of both follow to the same accuracy.
// Seconds: 5
#include <gtest/gtest.h>

#include <fstream>

#include "proto/contract/scene_meshes.h"
#include "proto/contract/scene_text.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/shipped_scenes.h"
#include "tests/support/temporary_directory.h"
#include "worker/scene/chute.h"
#include "worker/scene/chute_plan.h"

namespace granary::tests {
namespace {

using core::Vec3;

constexpr std::uint64_t kNoLimit = std::uint64_t{1} << 40;

// Floor and side walls of a chute 30 mm long and 80 mm wide, in millimetres; longer than the chute
// at both ends, where planes go on.
std::vector<dem::Triangle> walls_in_millimetres() {
  const Vec3 corner{-20, 0, 0}, along{100, 0, 0}, across{0, 80, 0}, up{0, 0, 200};
  std::vector<dem::Triangle> walls = sheet(corner, along, across, 8, 5);
  append(walls, sheet(corner, along, up, 3, 4));
  append(walls, sheet(corner + across, along, up, 2, 5));
  return walls;
}

void write_stl(const std::filesystem::path& file, const std::vector<dem::Triangle>& triangles) {
  std::ofstream out(file);
  out.precision(17);
  out << "solid chute\n";
  for (const dem::Triangle& t : triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (const Vec3& p : {t.a, t.b, t.c}) {
      out << "vertex " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    }
    out << "endloop\nendfacet\n";
  }
  out << "endsolid chute\n";
}

v1::Scene short_chute(const std::string& precision) {
  return shipped_scene("chute_small", {{"chute.duration_s", "0.05"},
                                       {"chute.sample_start_s", "0.02"},
                                       {"chute.length_m", "0.03"},
                                       {"chute.precision", precision}});
}

v1::Scene mesh_chute(const std::string& precision) {
  const testing::TemporaryDirectory folder;
  write_stl(folder / "chute.stl", walls_in_millimetres());
  v1::Scene scene = short_chute(precision);
  scene.mutable_chute()->set_no_walls(true);
  v1::Mesh* mesh = scene.mutable_chute()->add_meshes();
  mesh->set_stl_file("chute.stl");
  mesh->set_unit_m(0.001);
  const Status inlined = inline_meshes(scene, (folder / "scene.txtpb").string());
  EXPECT_TRUE(inlined.ok()) << (inlined.ok() ? "" : inlined.error().message);
  return scene;
}

std::vector<Vec3> positions_by_id(const core::Simulation& simulation) {
  std::vector<Vec3> all;
  const core::State state = simulation.snapshot();
  const auto position = state.get<double>("dem.position_m");
  const auto id = state.get<std::int64_t>("dem.id");
  for (std::size_t k = 0; k < id.size(); ++k) {
    all.resize(std::max<std::size_t>(all.size(), static_cast<std::size_t>(id[k]) + 1));
    all[static_cast<std::size_t>(id[k])] = {position[3 * k], position[3 * k + 1],
                                            position[3 * k + 2]};
  }
  return all;
}

TEST(ChuteMesh, walls_from_an_stl_file_are_the_walls_made_of_planes) {
  const auto planes = scene::make_chute(short_chute("DOUBLE"));
  const auto mesh = scene::make_chute(mesh_chute("DOUBLE"));
  planes->advance(1, kNoLimit);
  mesh->advance(1, kNoLimit);
  const std::vector<Vec3> expected = positions_by_id(*planes), found = positions_by_id(*mesh);
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_GT(found.size(), 500U);
  double largest = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    largest = std::max(largest, norm(found[k] - expected[k]));
  }
  EXPECT_LT(largest, 1e-6);
  EXPECT_EQ(mesh->observe().values.size(), planes->observe().values.size());
}

// Grains of a settled bed are put in around a wedge on the floor, not into its sides.
TEST(ChuteMesh, bed_settles_around_a_wedge) {
  const v1::Scene scene = shipped_scene("chute_splitter", {{"chute.inlet.feed", "NONE"},
                                                           {"chute.closed_end", "true"},
                                                           {"chute.initial_count", "3000"},
                                                           {"chute.duration_s", "0.01"},
                                                           {"chute.sample_start_s", "0"}});
  ASSERT_EQ(scene.chute().triangles_size(), 7);
  const auto run = scene::make_chute(scene);
  EXPECT_EQ(run->advance(1, kNoLimit).status, core::AdvanceStatus::finished);
  EXPECT_EQ(run->progress().particles, 3000U);
}

TEST(ChuteMesh, restored_run_goes_on_bitwise) {
  const auto hash_of = [](const core::Simulation& simulation) {
    return core::hash_columns(simulation.physical_state());
  };
  const auto whole = scene::make_chute(mesh_chute("MIXED"));
  whole->advance(0.0331, kNoLimit);
  const core::State state = whole->snapshot();
  whole->advance(1, kNoLimit);
  const auto resumed = scene::make_chute(mesh_chute("MIXED"));
  resumed->restore(state);
  EXPECT_EQ(resumed->advance(1, kNoLimit).status, core::AdvanceStatus::finished);
  EXPECT_EQ(hash_of(*whole), hash_of(*resumed));
  EXPECT_EQ(whole->ledger().remainder_j(), resumed->ledger().remainder_j());
  EXPECT_LT(std::abs(whole->ledger().remainder_j()), 1e-4 * whole->ledger().throughput_j);
}

}  // namespace
}  // namespace granary::tests
