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

struct Downhill {
  double acceleration, spin_acceleration;  // m/s2; the second at the surface
};

// A disk of 2 mm let go on a plane rising to +x: its motion over 0.2 s once its contact has
// settled.
inline Downhill roll_down(System& system, double slope_deg) {
  const double angle = radians(slope_deg), radius = 0.002;
  system.time_step = 1e-3;
  add_plane(system, angle, 2);
  add_disk(system, {-radius * std::sin(angle), radius * std::cos(angle)}, radius, 1000);
  reset_contacts(system);
  run(system, 0.1);
  const DiskMotion early = system.disks.motion[0];
  run(system, 0.2);
  const DiskMotion late = system.disks.motion[0];
  const Vec2 gain{late.vx - early.vx, late.vy - early.vy};
  return {-dot(gain, {std::cos(angle), std::sin(angle)}) / 0.2,
          (late.surface_speed - early.surface_speed) / 0.2};
}

}  // namespace granary::dda
