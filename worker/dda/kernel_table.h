// The table of one instruction set: a set of kernels for each combination of contact laws.
#pragma once

#include <utility>

#include "worker/dda/kernel_narrow_phase.h"
#include "worker/dda/kernel_small_steps.h"

namespace granary::dda {
namespace {

template <ContactEffects kEffects>
constexpr ContactKernels contact_kernels_of() {
  ContactKernels kernels{.sweep = nullptr,
                         .apply_impulses = apply_impulses<kEffects>,
                         .small_sweep_pairs = small_sweep_any<false, kEffects>,
                         .small_sweep_walls = small_sweep_any<true, kEffects>,
                         .close_pairs = close_contacts<false, kEffects>,
                         .close_walls = close_contacts<true, kEffects>};
  if constexpr (knows_one_solve(kEffects)) kernels.sweep = sweep<kEffects>;
  return kernels;
}

template <std::size_t... kIndex>
constexpr Kernels make_kernels(const char* name, std::index_sequence<kIndex...>) {
  return {
      name, select_pairs, advance_disks, {contact_kernels_of<kContactCombinations[kIndex]>()...}};
}

constexpr Kernels make_kernels(const char* name) {
  return make_kernels(name, std::make_index_sequence<kCombinationCount>());
}

}  // namespace
}  // namespace granary::dda
