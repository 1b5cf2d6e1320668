// Whether the engines keep the books of the energy ledger and of the sentinels. They always do;
// only tests/bench/effect_cost.py compiles kernels without, to see what the books cost.
#pragma once

#include <cstdint>

namespace granary::core {

#ifdef GRANARY_WITHOUT_BOOKS
inline constexpr bool kBooks = false;
#else
inline constexpr bool kBooks = true;
#endif

// Steps between two states that nobody checks.
inline constexpr std::uint64_t kNever = std::uint64_t{1} << 62;

}  // namespace granary::core
