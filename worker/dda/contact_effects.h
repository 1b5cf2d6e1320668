// Which contact laws a kernel holds. Each combination of this table is compiled on its own, so a
// law that is off is not in the machine code of the kernel that runs (ARCHITECTURE section 5).
// proto/contract/contact_effects.h holds the same table for scenes; a test compares the two.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>

namespace granary::dda {

struct ContactEffects {
  bool rotation = true;  // contacts turn disks; off: spins stay as they are
  bool history = true;   // sticking contacts keep a stretched spring; off: they keep no slip at all
  bool cohesion = false;  // contacts hold up to F_c
  bool rolling = false;   // rolling resistance mu_r; acts on spins, so it needs rotation
  bool operator==(const ContactEffects&) const = default;
};

inline constexpr ContactEffects kContactCombinations[] = {
    {},
    {.cohesion = true},
    {.rolling = true},
    {.cohesion = true, .rolling = true},
    {.history = false},
    {.rotation = false},
    {.rotation = false, .cohesion = true},
    {.rotation = false, .history = false},
};
inline constexpr std::size_t kCombinationCount = std::size(kContactCombinations);

// Only small steps know every law; one solve per step (Newmark, OPEN_CLOSE) knows spin or no spin.
constexpr bool knows_one_solve(const ContactEffects& effects) {
  return effects.history && !effects.cohesion && !effects.rolling;
}

// Position in the table, kCombinationCount if there is no such kernel.
constexpr std::size_t combination_index(const ContactEffects& effects) {
  std::size_t k = 0;
  while (k < kCombinationCount && kContactCombinations[k] != effects) ++k;
  return k;
}

// Groups of contacts whose law was evaluated, counted where it stands in the kernels: 0 proves that
// an effect did not run.
struct EffectCounts {
  std::uint64_t rotation = 0, history = 0, cohesion = 0, rolling = 0;

  void add(const EffectCounts& other) {
    rotation += other.rotation, history += other.history;
    cohesion += other.cohesion, rolling += other.rolling;
  }
};

}  // namespace granary::dda
