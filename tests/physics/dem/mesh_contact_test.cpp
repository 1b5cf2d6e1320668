// Claim: triangles push a sphere as the surface they form, wherever they are cut: one contact on a
//   flat floor, the closed-form normal on edges and corners, two or three contacts in hollow edges
//   and corners; and friction springs live on from one triangle to the next.
// Method: geometry of single touches; a bead that slides, rolls and stops on a floor of 1600
//   triangles against the same bead on a plane; a settling stream in a trough of triangles against
//   one between planes; rebounds from a block's corner; swings in a pipe of facets; energy ledgers.
// Reference: the plane (same law, no mesh); normal = (centre - nearest point) / distance; head-on
//   restitution e_n.
// Tolerance: plain engine: a plane through a triangle's corner and the plane itself differ by the
//   rounding of centre - corner, 1 ulp of 0.1 m = 1.4e-17 m per step; the forces of one bead are
//   not chaotic, so 20,000 steps stay below 1e-12 m. Streams amplify by e in 2 ms (PHYSICS G): 1000
//   steps of 1e-17 m, 10 ms, e^5: 2e-12 m if all rounding added up; 1e-12 m is asked for. Block
//   engine: contacts with planes are in float there, those with the mesh in double: 1e-6 of the
//   path for one bead; in the stream an impact is off by 6e-8 of 1 m/s, in 10 ms by 6e-10 m x e^5 =
//   1e-7.
// Seconds: 3
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/dem_cases.h"
#include "tests/support/mesh_cases.h"
#include "worker/core/random.h"
#include "worker/dem/surface_mesh.h"

namespace granary::tests {
namespace {

using core::Vec3;

constexpr double kRadius = 0.0015;

dem::TouchList touches_at(const std::vector<dem::Triangle>& triangles, const Vec3& centre,
                          double radius) {
  const dem::SurfaceMesh mesh(triangles);
  std::vector<std::uint32_t> near;
  std::vector<dem::SurfaceMesh::Foot> feet;
  mesh.add_near(centre, radius, near);
  return mesh.touches(centre, radius, near, feet);
}

// ---------------------------------------------------------------------------------- single touches

TEST(MeshTouch, flat_floor_is_touched_once_wherever_it_is_cut) {
  const auto floor = sheet({-0.01, -0.01, 0}, {0.02, 0, 0}, {0, 0.02, 0}, 20, 20);
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const auto random = [&](std::uint64_t stream) {
      return core::random_uniform(5, stream, k) - 0.5;
    };
    // One in two straight above an edge or a node, where every side test is a tie.
    const bool on_grid = k % 2 == 0;
    Vec3 centre{0.015 * random(1), 0.015 * random(2), kRadius * (0.97 + 0.05 * random(3))};
    if (on_grid) centre.x = 1e-3 * std::round(centre.x / 1e-3);
    if (k % 4 == 0) centre.y = 1e-3 * std::round(centre.y / 1e-3);
    const dem::TouchList found = touches_at(floor, centre, kRadius);
    ASSERT_EQ(found.count, centre.z < kRadius ? 1U : 0U) << k;
    if (found.count == 0) continue;
    EXPECT_NEAR(found.touch[0].overlap, kRadius - centre.z, 1e-17);
    EXPECT_NEAR(found.touch[0].normal.z, 1, 1e-15);
  }
}

TEST(MeshTouch, edges_and_corners_of_a_block_have_the_normal_from_the_nearest_point) {
  const double side = 0.004;
  const auto block = block_mesh(side, 3);
  for (std::uint64_t k = 0; k < 4000; ++k) {
    const auto random = [&](std::uint64_t stream) { return core::random_uniform(6, stream, k); };
    const auto coordinate = [&](std::uint64_t stream) {
      return -kRadius + (side + 2 * kRadius) * random(stream);
    };
    const Vec3 centre{coordinate(1), coordinate(2), coordinate(3)};
    const Vec3 nearest{std::clamp(centre.x, 0.0, side), std::clamp(centre.y, 0.0, side),
                       std::clamp(centre.z, 0.0, side)};
    const Vec3 apart = centre - nearest;
    const double distance = norm(apart);
    if (distance < 0.2 * kRadius) continue;  // inside, or nearly
    const dem::TouchList found = touches_at(block, centre, kRadius);
    ASSERT_EQ(found.count, distance < kRadius ? 1U : 0U) << k;
    if (found.count == 0) continue;
    EXPECT_NEAR(found.touch[0].overlap, kRadius - distance, 1e-16);
    EXPECT_NEAR(norm(found.touch[0].normal - apart * (1 / distance)), 0, 1e-12);
  }
}

// From inside, the same block is a box: one contact with each face in reach.
TEST(MeshTouch, hollow_corner_is_touched_three_times) {
  const double side = 0.01;
  const auto box = block_mesh(side, 4);
  const Vec3 centre{0.98 * kRadius, 0.97 * kRadius, 0.96 * kRadius};
  const dem::TouchList found = touches_at(box, centre, kRadius);
  ASSERT_EQ(found.count, 3U);
  EXPECT_NEAR(found.touch[0].overlap, 0.04 * kRadius, 1e-16);
  EXPECT_NEAR(found.touch[0].normal.z, 1, 1e-15);
  EXPECT_NEAR(found.touch[1].overlap, 0.03 * kRadius, 1e-16);
  EXPECT_NEAR(found.touch[1].normal.y, 1, 1e-15);
  EXPECT_NEAR(found.touch[2].overlap, 0.02 * kRadius, 1e-16);
  EXPECT_NEAR(found.touch[2].normal.x, 1, 1e-15);
}

TEST(MeshTouch, hanging_corners_on_an_edge_do_not_push_twice) {
  std::vector<dem::Triangle> floor = sheet({-0.01, -0.01, 0}, {0.01, 0, 0}, {0, 0.02, 0}, 1, 1);
  append(floor, sheet({0, -0.01, 0}, {0.01, 0, 0}, {0, 0.02, 0}, 3, 7));
  for (double x = -0.002; x < 0.002; x += 1e-5) {
    EXPECT_EQ(touches_at(floor, {x, 0.0004, 0.95 * kRadius}, kRadius).count, 1U) << x;
  }
}

// ------------------------------------------------------------------------------ against the plane

template <typename Engine>
class MeshWall : public ::testing::Test {
 protected:
  static constexpr bool is_double = std::is_same_v<Engine, dem::PlainEngine>;
};
TYPED_TEST_SUITE(MeshWall, DemEngines);

dem::EngineSetup slope(double degrees, double rolling_friction) {
  dem::EngineSetup setup = base_setup(1e-5);
  setup.motion.gravity = gravity_on_slope(degrees);
  setup.grain_wall.rolling_friction = rolling_friction;
  return setup;
}

// 1600 triangles under a path of 40 mm, aslant to all of their edges.
std::vector<dem::Triangle> cut_floor() {
  return sheet({-0.02, -0.02, 0}, {0.08, 0.003, 0}, {-0.002, 0.04, 0}, 40, 20);
}

TYPED_TEST(MeshWall, bead_takes_the_path_it_takes_on_a_plane) {
  for (const double degrees : {30.0, 5.0}) {  // slips and rolls; rolls slowly to a stop
    dem::EngineSetup plane = slope(degrees, 0.1);
    dem::EngineSetup mesh = plane;
    plane.walls = {floor_plane()};
    mesh.triangles = cut_floor();
    TypeParam on_plane(plane), on_mesh(mesh);
    const dem::Grain grain = grain_at({0, 0, kRadius - 3e-7}, {0.15, 0.04, 0}, {20, -30, 10});
    insert_one(on_plane, grain);
    insert_one(on_mesh, grain);
    double largest = 0;
    for (int k = 0; k < 100; ++k) {
      on_plane.advance(100);
      on_mesh.advance(100);
      largest = std::max(largest, norm(bead(on_plane).position - bead(on_mesh).position));
      ASSERT_EQ(on_mesh.contact_count(), on_plane.contact_count()) << k;
    }
    EXPECT_GT(bead(on_mesh).position.x, 0.005);
    EXPECT_LT(largest, this->is_double ? 1e-12 : 1e-6 * bead(on_plane).position.x) << degrees;
    EXPECT_NEAR(norm(bead(on_plane).spin - bead(on_mesh).spin), 0,
                this->is_double ? 1e-8 : 1e-5 * norm(bead(on_plane).spin));
  }
}

TYPED_TEST(MeshWall, bead_at_rest_on_an_edge_stays_at_rest) {
  dem::EngineSetup setup = slope(3, 0.1);
  setup.triangles = sheet({-0.01, -0.01, 0}, {0.01, 0, 0}, {0, 0.02, 0}, 1, 1);
  append(setup.triangles, sheet({0, -0.01, 0}, {0.01, 0, 0}, {0, 0.02, 0}, 1, 1));
  TypeParam engine(setup);
  const double weight = setup.classes[0].mass() * -setup.motion.gravity.z;
  insert_one(engine, grain_at({0, 0.001, kRadius - weight / 1000}));
  engine.advance(20'000);
  EXPECT_LT(std::abs(bead(engine).position.x), 1e-6);
  EXPECT_LT(norm(bead(engine).velocity), 0.51e-5 * kGravity);
}

// Head-on along the corner's bisector the rebound is that of a wall.
TYPED_TEST(MeshWall, corner_gives_back_the_normal_restitution) {
  dem::EngineSetup setup = base_setup(2e-6);
  setup.triangles = block_mesh(0.01, 2);
  const Vec3 outward = Vec3{-1, -1, -1} * (1 / std::sqrt(3.0));
  TypeParam engine(setup);
  insert_one(engine, grain_at(outward * (kRadius + 1e-6), outward * -1.0));
  engine.advance(1000);
  const Bead after = bead(engine);
  EXPECT_NEAR(dot(after.velocity, outward), 0.95, 1e-3);
  EXPECT_NEAR(norm(after.velocity - outward * dot(after.velocity, outward)), 0, 1e-6);
  EXPECT_NEAR(norm(after.spin) * kRadius, 0, 1e-6);
}

// ----------------------------------------------------------------------------------------- streams

constexpr double kLength = 0.06, kWidth = 0.02;

dem::EngineSetup trough() {
  dem::EngineSetup setup = slope(30, 0.02);
  setup.outlet_x = kLength;
  return setup;
}

dem::EngineSetup trough_of_planes() {
  dem::EngineSetup setup = trough();
  setup.walls = {floor_plane(), {{0, 0, 0}, {0, 1, 0}}, {{0, kWidth, 0}, {0, -1, 0}}};
  return setup;
}

dem::EngineSetup trough_of_triangles() {
  dem::EngineSetup setup = trough();
  const Vec3 along{kLength + 0.03, 0, 0}, across{0, kWidth, 0}, up{0, 0, 0.05};
  const Vec3 corner{-0.01, 0, 0};
  setup.triangles = sheet(corner, along, across, 31, 7);
  append(setup.triangles, sheet(corner, along, up, 5, 9));
  append(setup.triangles, sheet(corner + across, along, up, 7, 3));
  return setup;
}

void pour(dem::Engine& engine) {
  std::vector<dem::Grain> grains;
  for (double x = 0.002; x < kLength - 0.002; x += 0.0032) {
    for (double z = 0.00155; z < 0.01; z += 0.0031) {
      for (double y = 0.0016; y < kWidth - 0.0015; y += 0.0032) {
        const auto random = [&](std::uint64_t stream) {
          return core::random_uniform(9, stream, grains.size()) - 0.5;
        };
        grains.push_back(grain_at({x, y + 1e-4 * random(1), z},
                                  {0.5 + 0.4 * random(2), 0.4 * random(3), 0.4 * random(4)},
                                  {50 * random(5), 50 * random(6), 50 * random(7)}));
      }
    }
  }
  engine.insert(grains);
}

double farthest_apart(const dem::Engine& a, const dem::Engine& b) {
  const dem::GrainTable left = a.grains(), right = b.grains();
  if (left.size() != right.size()) return 1;
  std::vector<Vec3> place(10'000);
  for (std::size_t k = 0; k < left.size(); ++k) place[left.id[k]] = left.position[k];
  double largest = 0;
  for (std::size_t k = 0; k < right.size(); ++k) {
    largest = std::max(largest, norm(place[right.id[k]] - right.position[k]));
  }
  return largest;
}

TYPED_TEST(MeshWall, stream_in_a_trough_of_triangles_follows_the_one_between_planes) {
  TypeParam planes(trough_of_planes()), mesh(trough_of_triangles());
  pour(planes);
  pour(mesh);
  planes.advance(1000);
  mesh.advance(1000);
  EXPECT_GT(mesh.effect_counts().tangential_history, 20'000U);  // contacts, summed over the steps
  EXPECT_LT(farthest_apart(planes, mesh), this->is_double ? 1e-12 : 1e-7);
}

TYPED_TEST(MeshWall, energy_ledger_closes_as_between_planes) {
  TypeParam planes(trough_of_planes()), mesh(trough_of_triangles());
  for (dem::Engine* engine :
       {static_cast<dem::Engine*>(&planes), static_cast<dem::Engine*>(&mesh)}) {
    pour(*engine);
    engine->advance(4000);
    const core::EnergyLedger& ledger = engine->ledger();
    EXPECT_LT(std::abs(ledger.remainder_j()), 1e-4 * ledger.throughput_j);
    EXPECT_LT(engine->grain_count(), 1200U);
  }
}

TYPED_TEST(MeshWall, restored_run_goes_on_bitwise) {
  TypeParam whole(trough_of_triangles());
  pour(whole);
  whole.advance(1237);
  const core::State state = whole.snapshot();
  TypeParam resumed(trough_of_triangles());
  resumed.restore(state);
  whole.advance(1500);
  resumed.advance(1500);
  EXPECT_EQ(farthest_apart(whole, resumed), 0);
  EXPECT_EQ(whole.ledger().remainder_j(), resumed.ledger().remainder_j());
}

// Every combination of effects pushes and books on triangles as it does on planes.
TYPED_TEST(MeshWall, effects_act_on_triangles_as_on_planes) {
  for (const dem::EffectCombination& combination : dem::kEffectCombinations) {
    dem::EngineSetup plane = trough_of_planes(), mesh = trough_of_triangles();
    for (dem::EngineSetup* setup : {&plane, &mesh}) {
      setup->effects = combination.effects;
      setup->grain_grain.cohesion_bond = setup->grain_wall.cohesion_bond = 2;
    }
    TypeParam planes(plane), triangles(mesh);
    for (dem::Engine* engine :
         {static_cast<dem::Engine*>(&planes), static_cast<dem::Engine*>(&triangles)}) {
      pour(*engine);
      engine->advance(1000);
    }
    EXPECT_LT(farthest_apart(planes, triangles), this->is_double ? 1e-12 : 1e-7)
        << combination.name;
    // Booked in float and in double: 1e-6 of what went through.
    const core::EnergyLedger &expected = planes.ledger(), &found = triangles.ledger();
    for (std::size_t k = 0; k < core::kEnergyChannelCount; ++k) {
      EXPECT_NEAR(found.channels_j[k], expected.channels_j[k], 1e-6 * expected.throughput_j)
          << combination.name << k;
    }
  }
}

// A pipe of 40 mm along y, of 72 facets: a hollow crease every 5 degrees.
dem::EngineSetup pipe(double restitution, double friction) {
  dem::EngineSetup setup = base_setup(5e-6);
  setup.grain_wall.normal_restitution = restitution;
  setup.grain_wall.friction = friction;
  setup.motion.gravity = {0, 0, -kGravity};
  const auto rim = [](int facet, double y) {
    const double angle = 2 * std::numbers::pi * facet / 72;
    return Vec3{0.02 * std::sin(angle), y, -0.02 * std::cos(angle)};
  };
  for (int k = 0; k < 72; ++k) {
    setup.triangles.push_back({rim(k, -0.01), rim(k + 1, -0.01), rim(k + 1, 0.01)});
    setup.triangles.push_back({rim(k, -0.01), rim(k + 1, 0.01), rim(k, 0.01)});
  }
  return setup;
}

// The deepest contact has one potential all around the pipe. What a bead gains or loses in a second
// of swings without friction and damping is the integrator's: less than the 1e-3 that PHYSICS I
// allows a ledger.
TYPED_TEST(MeshWall, smooth_pipe_of_facets_keeps_the_energy) {
  TypeParam engine(pipe(1, 0));
  insert_one(engine, grain_at({0.0125, 0.001, -0.0125}));
  const auto energy = [&] {
    const core::EnergyLedger& ledger = engine.ledger();
    return ledger.kinetic_j + ledger.potential_j + ledger.elastic_j;
  };
  engine.advance(1);
  const double at_start = energy();
  double lowest = 0;
  for (int k = 0; k < 400; ++k) {
    engine.advance(500);
    lowest = std::min(lowest, bead(engine).position.z);
    ASSERT_LT(norm(bead(engine).position), 0.02);
  }
  EXPECT_LT(lowest, -0.0183);  // it has been at the bottom, 6 mm below
  const double swing = engine.setup().classes[0].mass() * kGravity * 0.006;
  EXPECT_NEAR(energy(), at_start, 1e-3 * swing);
}

// Springs are turned from facet to facet, which nobody books: 1e-4 as for a stream.
TYPED_TEST(MeshWall, rough_pipe_of_facets_closes_its_ledger) {
  TypeParam engine(pipe(0.95, 0.22));
  insert_one(engine, grain_at({0.0125, 0.001, -0.0125}));
  engine.advance(200'000);
  EXPECT_LT(bead(engine).position.z, -0.0145);  // below where it began
  EXPECT_GT(bead(engine).position.z, -0.0186);
  const core::EnergyLedger& ledger = engine.ledger();
  EXPECT_LT(std::abs(ledger.remainder_j()), 1e-4 * ledger.throughput_j);
}

TEST(BlockMesh, threads_change_no_bit) {
  dem::EngineSetup setup = trough_of_triangles();
  dem::BlockEngine one(setup);
  setup.threads = 3;
  dem::BlockEngine three(setup);
  pour(one);
  pour(three);
  one.advance(2000);
  three.advance(2000);
  EXPECT_EQ(farthest_apart(one, three), 0);
  EXPECT_EQ(one.ledger().remainder_j(), three.ledger().remainder_j());
}

// With walls that turn, in the laboratory's axes: a bead on a mesh goes where it goes on a plane.
TEST(PlainMesh, turns_with_the_chute) {
  dem::EngineSetup plane = slope(30, 0);
  plane.motion.omega = chute_omega(16, 30);
  plane.motion.frame = dem::FrameKind::inertial;
  dem::EngineSetup mesh = plane;
  plane.walls = {floor_plane()};
  mesh.triangles = cut_floor();
  dem::PlainEngine on_plane(plane), on_mesh(mesh);
  for (dem::PlainEngine* engine : {&on_plane, &on_mesh}) {
    insert_one(*engine, grain_at({0, 0, kRadius}, {0.1, 0, 0}));
    engine->advance(8000);
  }
  EXPECT_GT(bead(on_mesh).position.x, 0.01);
  EXPECT_LT(norm(bead(on_plane).position - bead(on_mesh).position), 1e-12);
}

}  // namespace
}  // namespace granary::tests
