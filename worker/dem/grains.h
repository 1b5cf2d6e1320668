// Grains as the outside of the engine sees them.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/core/vec3.h"

namespace granary::dem {

// State of all grains at one time: chute axes, full-step velocities, spins relative to the chute.
// The order is the engine's own and may change from call to call; ids do not.
struct GrainTable {
  std::vector<std::int64_t> id;
  std::vector<core::Vec3> position;  // m
  std::vector<core::Vec3> velocity;  // m/s
  std::vector<core::Vec3> spin;      // rad/s
  std::vector<double> radius;        // m
  std::vector<double> mass;          // kg
  std::vector<std::uint8_t> grain_class;
  std::vector<std::uint8_t> carried;
  std::size_t size() const { return id.size(); }
};

// A grain that crossed the outlet, interpolated to the crossing.
struct Leaver {
  double time = 0;
  std::int64_t id = 0;
  core::Vec3 position;
  core::Vec3 velocity;
  double diameter = 0;
  double mass = 0;
};

}  // namespace granary::dem
