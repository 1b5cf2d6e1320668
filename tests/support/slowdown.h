// Sanitizers make programs slower: deadlines that only guard against a hang are stretched by this.
#pragma once

#ifndef GRANARY_SLOWDOWN
#define GRANARY_SLOWDOWN 1
#endif

namespace granary::test {

inline constexpr int kSlowdown = GRANARY_SLOWDOWN;

}  // namespace granary::test
