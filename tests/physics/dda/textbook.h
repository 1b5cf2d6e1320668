// Small systems set up by hand, for closed-form checks.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "worker/dda/step.h"
#include "worker/dda/system.h"

namespace granary::dda {

inline double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// A disk of `density` [kg/m2] at rest.
inline void add_disk(System& system, Vec2 centre, double radius, double density) {
  const double mass = density * std::numbers::pi * radius * radius;
  system.disks.add({centre.x, centre.y, radius, 0}, {0, 0, 0, 1 / mass}, 0);
}

// A fixed straight wall through the origin, rising to +x by `angle` [rad].
inline void add_plane(System& system, double angle, double half_length) {
  const Vec2 along{half_length * std::cos(angle), half_length * std::sin(angle)};
  const std::vector<Vec2> points = {Vec2{} - along, along};
  system.walls.add_chain(points, false);
}

inline void run(System& system, double duration) {
  const auto steps = static_cast<long>(std::lround(duration / system.time_step));
  for (long k = 0; k < steps; ++k) step(system);
}

}  // namespace granary::dda
