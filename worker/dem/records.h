// How the block engine keeps a grain: 96 bytes in cell order, read and written as whole vectors,
// and 64 bytes that collect what pushes it. Spins are kept as surface speeds R w: a solid sphere
// then turns by d(R w)/dt = 5/2 (n x F_t) / m, so that one inverse mass serves force and turning.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace granary::dem {

struct alignas(64) GrainMotion {
  double position[3] = {};  // full step [m]
  double inverse_mass = 0;  // 1/kg
  double velocity[3] = {};  // half a step earlier [m/s]
  double free_step = 0;     // dt [s]; 0 while carried: then no force moves it
};

struct alignas(32) GrainSurface {
  double speed[3] = {};  // R w at the half step [m/s]
  double radius = 0;     // m
};

struct alignas(64) GrainLoad {
  double turning[3] = {};  // sum of n x F_t, torque / R [N]
  double unused_turning = 0;
  double force[3] = {};  // N
  double unused_force = 0;
};

static_assert(sizeof(GrainMotion) == 64 && sizeof(GrainSurface) == 32 && sizeof(GrainLoad) == 64);

// Storage that vector loads may touch: 64-byte lines.
template <typename T>
struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <typename U>
  LineAllocator(const LineAllocator<U>&) {}
  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{64}));
  }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  bool operator==(const LineAllocator&) const { return true; }
};

template <typename T>
using LineVector = std::vector<T, LineAllocator<T>>;

}  // namespace granary::dem
