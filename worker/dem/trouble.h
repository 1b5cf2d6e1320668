// What both engines share in their books and sentinels.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/core/energy_ledger.h"
#include "worker/core/simulation.h"

namespace granary::dem {

// Overlap / radius; beyond, the linear law means nothing.
inline constexpr double kLargestSoundOverlap = 0.5;

// Path of one step / radius; beyond, a grain may be through a wall of triangles, or through another
// grain, without ever having touched it.
inline constexpr double kLongestSoundPath = 0.5;

// A lone grain among half-spaces has nothing thin to pass.
inline bool can_pass_through(std::size_t grains, bool has_mesh) {
  return grains > 1 || has_mesh;
}

core::Rejection path_too_long(double time, double path_ratio, std::vector<std::int64_t> ids);
core::Rejection not_a_number(double time, std::vector<std::int64_t> ids);
core::Rejection overlap_too_deep(double time, double overlap_ratio, std::vector<std::int64_t> ids);

inline void book_into(core::EnergyLedger& ledger, core::EnergyChannel channel, double energy) {
  ledger[channel] += energy;
  ledger.throughput_j += std::abs(energy);
}

}  // namespace granary::dem
