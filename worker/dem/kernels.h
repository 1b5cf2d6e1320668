// The loops that cost the time. One source (kernels_body.h) is compiled once per instruction set
// and once per combination of contact effects, and chosen at run time. All variants do the same
// IEEE operations on the same sixteen lanes in the same order, without contraction, so they give
// the same bits (tests/unit/worker/dem/kernels_test.cpp). Contacts come in groups of kLanes. Lists
// are padded to whole groups; padding is masked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "worker/dem/contact_law.h"
#include "worker/dem/records.h"

namespace granary::dem {

inline constexpr std::size_t kLanes = 16;

// What a contact remembers, from its first grain to its second.
struct alignas(32) History {
  float spring[3] = {};    // tangential elongation [m]; without history: tangential force [N]
  float touched = 0;       // 1 when it touched in the last step
  float velocity[3] = {};  // at the contact in the last step [m/s]
  float unused = 0;
};

// Coefficients by kind of contact, for lane-wise look-up. kind = class_a * classes + class_b; of a
// wall: class_a.
inline constexpr std::size_t kMaxClasses = 8;
inline constexpr std::size_t kMaxKinds = kMaxClasses * kMaxClasses;
struct alignas(64) LawTables {
  using Row = float[kMaxKinds];
  Row reach;           // R_a + R_b [m]
  Row near_square;     // of a distance that rounding may take for a touch [m2]
  Row inverse_radius;  // 1 / the smaller one [1/m]
  Row normal_stiffness;
  Row normal_damping;
  Row tangential_stiffness;
  Row tangential_damping;
  Row friction;
  Row inverse_tangential_stiffness;  // 0 without history
  Row cohesion;                      // attraction while in touch [N]
  Row rolling_arm;                   // mu_r R_r [m]
  Row stopping;                      // reduced inertia / dt
  Row inverse_radius_a;
  Row inverse_radius_b;  // of a wall 0
  Row spin_response;     // (R_a/I_a - R_b/I_b) dt
  std::size_t kinds = 1;
};

inline constexpr std::size_t kMaxWalls = 64;
struct alignas(64) WallTables {
  float normal_x[kMaxWalls];
  float normal_y[kMaxWalls];
  float normal_z[kMaxWalls];
  std::size_t count = 0;
};

// Contacts that may act within the horizon of the inner list. Indices are local to the block and
// counted in bytes of GrainSurface.
struct SlotArrays {
  std::size_t count = 0;
  const std::uint32_t* first = nullptr;
  const std::uint32_t* second = nullptr;  // grains; of a wall contact: the wall
  const std::uint8_t* kind = nullptr;
  // Wall contacts: where the grain's centre just touches the wall, near the grain. What is left
  // between the two is the overlap, in full float precision.
  const GrainMotion* foot = nullptr;
  History* history = nullptr;  // one more than there are slots: padding writes there
  // Pairs only: one bit per lane and group, pairs that were near in the last step; and room for the
  // slots, firsts and seconds of those that are or were, count + 2 kLanes each.
  std::uint16_t* near = nullptr;
  std::uint32_t* active[3] = {};
};

// Borrowed arrays of one block; load covers the block and the grains of the next that it touches.
struct BlockArrays {
  GrainMotion* motion = nullptr;
  GrainSurface* surface = nullptr;
  GrainLoad* load = nullptr;
  std::size_t count = 0;
};

// What contacts took out of the grains in one step [J], and what sentinels and counters look at.
struct ContactSums {
  double normal_damping = 0;
  double friction = 0;
  double rolling = 0;
  float largest_overlap_ratio = 0;
  std::uint64_t contacts = 0;
};

struct ContactTask {
  BlockArrays block;
  SlotArrays slots;
  const LawTables* laws = nullptr;
  const WallTables* walls = nullptr;
  float time_step = 0;
};
using ContactKernel = void (*)(const ContactTask&, ContactSums&);

// One half kick of the leapfrog for every grain, rows by component:
//   N = contacts / m + constant (+ per_position x + per_velocity v + ...), v += N free_step, x += v
//   dt
struct BodyCoefficients {
  double time_step = 0;
  double turning_factor = 2.5;  // 0: grains do not turn
  double constant[3] = {};      // gravity; in a rotating frame what is left at x = 0
  // Rotating frame only; matrices as three rows of products with (v_i, v_i+1, v_i+2).
  double per_position[3][3] = {};
  double per_velocity[3][3] = {};
  double per_force[3][3] = {};
  double per_surface[3][3] = {};
  double per_turning[3][3] = {};
};
struct IntegrateTask {
  BlockArrays block;
  const GrainLoad* inflow = nullptr;  // from the block before, for the first inflow_count grains
  std::size_t inflow_count = 0;
  const BodyCoefficients* body = nullptr;
};
using IntegrateKernel = void (*)(const IntegrateTask&);

// Outer pairs that could touch within `horizon`: gap + min(0, v_n) horizon < margin. Writes their
// slot numbers, with kOverlaps set where the grains already overlap; room for 16 more than there
// are pairs.
inline constexpr std::uint32_t kOverlaps = 1U << 31;
struct PruneTask {
  const GrainMotion* motion = nullptr;
  const std::uint32_t* first = nullptr;  // local indices
  const std::uint32_t* second = nullptr;
  const std::uint8_t* kind = nullptr;
  std::size_t count = 0;
  const LawTables* laws = nullptr;
  float horizon = 0;
  float margin = 0;
  std::uint32_t* survivors = nullptr;
};
using PruneKernel = std::size_t (*)(const PruneTask&);

// All pairs within reach of the grains of one cell with partners further on in memory: the rest of
// their own row and whole rows of neighbour cells. Coordinates in float; room for 16 more.
struct SearchTask {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
  const float* radius = nullptr;
  std::uint32_t begin = 0, end = 0;  // grains of the cell
  std::uint32_t row_end = 0;         // of the cells beyond it in its own row
  std::uint32_t rows[4][2] = {};     // begin and end of the neighbour rows
  float skin = 0;
  std::uint32_t origin = 0;  // subtracted from every index written
  std::uint32_t* first = nullptr;
  std::uint32_t* second = nullptr;
};
using SearchKernel = std::size_t (*)(const SearchTask&);

// Named combinations of contact effects; without spin there is nothing to roll.
struct EffectCombination {
  const char* name;
  ContactEffects effects;
};
inline constexpr EffectCombination kEffectCombinations[] = {
    {"spring + rolling + spin + cohesion", {true, true, true, true}},
    {"spring + spin + cohesion", {true, false, true, true}},
    {"spring + rolling + spin", {true, true, true}},
    {"spring + spin", {true, false, true}},
    {"spring", {true, false, false}},
    {"rolling + spin", {false, true, true}},
    {"spin", {false, false, true}},
    {"normal + sliding", {false, false, false}},
};
inline constexpr std::size_t kEffectCombinationCount = std::size(kEffectCombinations);

struct Kernels {
  const char* name;
  ContactKernel pairs[kEffectCombinationCount];
  ContactKernel walls[kEffectCombinationCount];
  IntegrateKernel integrate[2];  // without and with spin
  IntegrateKernel integrate_rotating[2];
  PruneKernel prune;
  SearchKernel search;
};

// Row of kEffectCombinations that runs a setup. Rolling friction counts only if some contact has
// it. Absent where there is none.
std::optional<std::size_t> effect_combination(const ContactEffects& effects, bool has_rolling_arm);

// The fastest variant that this processor runs.
const Kernels& kernels();

// All variants that this processor runs, slowest first.
std::span<const Kernels* const> available_kernels();

}  // namespace granary::dem
