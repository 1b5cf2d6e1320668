// Contacts in two stages. A `CandidateList` lives from one neighbour search to the next: the pairs
// that may touch, with the force each carried in the last step (stick memory and warm start). Every
// step the narrow phase picks those that can act into `ActiveContacts`, the solver's arrays.
//
// Both are ordered by colour, in blocks of neighbouring contacts: no two contacts of one colour
// share a disk, so a group of kGroupSize contacts is updated at once, with the same result for any
// vector width. Each colour is padded to whole groups with contacts between the resting record and
// itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/dda/aligned_vector.h"

namespace granary::dda {

inline constexpr std::size_t kGroupSize = 8;

inline constexpr double kNoRebound = -1e30;

struct CandidateList {
  AlignedVector<std::int32_t> first;        // disk
  AlignedVector<std::int32_t> second;       // disk; wall segment in the wall list
  AlignedVector<double> normal_force;       // N, end of the last step, >= 0 without cohesion
  AlignedVector<double> tangential_force;   // N, along the contact tangent (-ny, nx)
  AlignedVector<double> rolling_force;      // N, torque / radius; 0 without rolling resistance
  std::vector<std::uint32_t> colour_start;  // multiples of kGroupSize; last = size()

  std::size_t size() const { return first.size(); }
};

// n = unit normal from `first` to `second`; impulses P act on `second`, -P on `first`.
// Residuals that the sweeps drive to zero (PHYSICS section F), u = relative velocity at the end:
//   normal      u_n + bias_n + compliance P_n >= 0, P_n >= 0, one of them 0
//   tangential  u_t + bias_t + compliance P_t  = 0 within |P_t| <= mu P_n
struct ActiveContacts {
  AlignedVector<std::int32_t> first, second, slot;  // slot: index in the candidate list
  AlignedVector<double> normal_x, normal_y;
  AlignedVector<double> bias_n, bias_t;        // m/s
  AlignedVector<double> weight_n, weight_t;    // relaxation / (effective inverse mass + compliance)
  AlignedVector<double> impulse_n, impulse_t;  // N s
  AlignedVector<double> gap_start;             // m, < 0 where disks overlap
  AlignedVector<double> stored_t;              // N, tangential force at the start of the step

  // For small steps within the step. After a relative displacement d of the bodies
  //   gap = gap_linear + d_n + curvature (offset_t + d_t)^2,
  // the distance along the fixed normal and its second-order change by turning.
  AlignedVector<double> gap_linear;  // m
  AlignedVector<double> offset_t;    // m, of the centres along the tangent
  AlignedVector<double> curvature;   // 1/m; 0 at walls
  AlignedVector<double> gap_now;     // m
  AlignedVector<double> stick_t;     // N s, tangential impulse of the small step before
  AlignedVector<double> slide_t;     // m, of the surfaces, since the start of the step
  AlignedVector<double> rebound;     // m/s, u_n after the gap closes; kNoRebound = no collision
  std::vector<std::uint8_t> group_rebounds;  // per group: some contact of it may collide
  AlignedVector<double> drift_n, drift_t;    // m/s, of walls, against the disk's zero velocity

  // Rolling resistance: torque impulse P_r R on `second`, R = 2 r_1 r_2 / (r_1 + r_2), at walls r.
  // Empty without it.
  AlignedVector<double> arm_first, arm_second;  // R / radius
  AlignedVector<double> weight_r;
  AlignedVector<double> impulse_r;  // N s
  AlignedVector<double> rolled;     // m, R times the angle between the bodies since the step began
  AlignedVector<double> drift_r;    // m/s, R times the spin of walls

  std::size_t size = 0;           // padded
  std::size_t contact_count = 0;  // without padding

  void reserve(std::size_t capacity);
  void reserve_rolling();  // after reserve()
};

}  // namespace granary::dda
