// Small DEM set-ups that physics tests share: the chute paper's base contact data (Table 1), a bead
// on a plane, two beads. Engines under test are listed once, so that every claim holds for all of
// them.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "worker/dem/block_engine.h"
#include "worker/dem/plain_engine.h"
#include "worker/dem/setup.h"

namespace granary::tests {

using DemEngines = ::testing::Types<dem::PlainEngine, dem::BlockEngine>;

// The engine that runs a setup: the block engine does not follow turning walls.
template <typename Engine>
std::unique_ptr<dem::Engine> engine_for(const dem::EngineSetup& setup) {
  if (setup.motion.frame == dem::FrameKind::inertial) return dem::make_engine(setup);
  return std::make_unique<Engine>(setup);
}

inline constexpr double kGravity = 9.81;

inline double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

inline dem::ContactParameters base_grain_grain() {
  return {1000, 0.97, 0.33, 0.12, 0, 0};
}
inline dem::ContactParameters base_grain_wall() {
  return {1000, 0.95, 0.33, 0.22, 0, 0};
}

// Base grains, no gravity, no walls.
inline dem::EngineSetup base_setup(double time_step) {
  dem::EngineSetup setup;
  setup.classes = {dem::GrainClass{0.0015, 2550}};
  setup.grain_grain = base_grain_grain();
  setup.grain_wall = base_grain_wall();
  setup.time_step = time_step;
  return setup;
}

inline dem::Plane floor_plane() {
  return {{0, 0, 0}, {0, 0, 1}};
}

// Gravity in axes whose x runs down a slope of this angle.
inline core::Vec3 gravity_on_slope(double degrees) {
  return {kGravity * std::sin(radians(degrees)), 0, -kGravity * std::cos(radians(degrees))};
}

// Rotation of the chute as `rotation_rpm` means it: > 0 is clockwise seen from above, so the vector
// points down along gravity (PHYSICS section H1).
inline core::Vec3 chute_omega(double rpm, double slope_degrees) {
  const double rate = rpm * 2 * std::numbers::pi / 60;
  return gravity_on_slope(slope_degrees) * (rate / kGravity);
}

struct Bead {
  core::Vec3 position;
  core::Vec3 velocity;
  core::Vec3 spin;
};

inline dem::Grain grain_at(const core::Vec3& position, const core::Vec3& velocity = {},
                           const core::Vec3& spin = {}) {
  dem::Grain grain;
  grain.position = position;
  grain.velocity = velocity;
  grain.spin = spin;
  return grain;
}

template <typename Engine>
void insert_one(Engine& engine, const dem::Grain& grain) {
  engine.insert(std::span(&grain, 1));
}

template <typename Engine>
Bead bead(const Engine& engine, std::int64_t id = 0) {
  const dem::GrainTable table = engine.grains();
  for (std::size_t k = 0; k < table.size(); ++k) {
    if (table.id[k] == id) return {table.position[k], table.velocity[k], table.spin[k]};
  }
  ADD_FAILURE() << "no grain " << id;
  return {};
}

// Throws one bead at the floor and follows it until it has left again. It starts half a step above
// contact: the onset falls between two steps, as it does in a flow.
template <typename Engine>
Bead rebound(const dem::EngineSetup& setup, const core::Vec3& velocity,
             const core::Vec3& spin = {}) {
  Engine engine(setup);
  const double radius = setup.classes[0].radius;
  insert_one(engine, grain_at({0, 0, radius - 0.5 * setup.time_step * velocity.z}, velocity, spin));
  for (int k = 0; k < 1'000'000; ++k) {
    engine.advance(1);
    const Bead now = bead(engine);
    if (now.position.z > radius && now.velocity.z > 0) {
      engine.advance(2);
      return bead(engine);
    }
  }
  ADD_FAILURE() << "the bead did not rebound";
  return {};
}

}  // namespace granary::tests
