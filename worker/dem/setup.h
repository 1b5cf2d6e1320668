// What a DEM run is made of, in SI units and chute coordinates (x downstream along the floor, y
// across, z normal to the floor; worker/dem/README.md). Plain data, fixed for the whole run.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "worker/core/vec3.h"
#include "worker/dem/contact_law.h"

namespace granary::dem {

struct GrainClass {
  double radius = 0.0015;  // m
  double density = 2550;   // kg/m3
  double mass() const;     // kg
  double inertia() const;  // solid sphere, 2/5 m R^2 [kg m^2]
};

// Infinite plane; grains live on the side the normal points to.
struct Plane {
  core::Vec3 point;
  core::Vec3 normal;  // unit
};

// Part of a mesh; acts on both sides. Precondition: it has an area.
struct Triangle {
  core::Vec3 a, b, c;
};

enum class FrameKind {
  corotating,  // equations of motion in chute axes, with centrifugal and Coriolis terms
  inertial     // laboratory axes that coincide with the chute's at t = 0; walls turn
};

struct Motion {
  core::Vec3 gravity;     // in chute axes at t = 0 [m/s2]
  core::Vec3 omega;       // rotation of the chute [rad/s]
  core::Vec3 axis_point;  // a point of the rotation axis [m]
  FrameKind frame = FrameKind::corotating;
  bool rotates() const { return omega != core::Vec3{}; }
};

enum class Damping {
  semi_implicit,      // velocity of the last half step in the dashpots
  predicted_velocity  // velocity predicted to the full step
};

enum class Precision {
  mixed,  // contacts in float on differences taken in double, sums and motion in double
  full    // double throughout, slower
};

struct EngineSetup {
  std::vector<GrainClass> classes;
  ContactParameters grain_grain;
  ContactParameters grain_wall;
  ContactEffects effects;
  std::vector<Plane> walls;
  std::vector<Triangle> triangles;  // more walls, at rest in the chute's axes
  Motion motion;
  double time_step = 1e-5;
  Damping damping = Damping::semi_implicit;
  double outlet_x = std::numeric_limits<double>::infinity();  // grains beyond it leave
  Precision precision = Precision::mixed;
  unsigned threads = 1;  // never change a result
};

// A grain as the outside sees it: chute axes, velocity at the full step, spin relative to the
// chute.
struct Grain {
  core::Vec3 position;
  core::Vec3 velocity;
  core::Vec3 spin;
  std::uint8_t grain_class = 0;
  bool carried = false;  // moves with constant velocity whatever pushes it, until it is released
};

// Largest stable time step [s]: 2 / sqrt(12 k_n / m) of the lightest grain in a crowd (PHYSICS D1).
double stable_time_step(const EngineSetup& setup);

}  // namespace granary::dem
