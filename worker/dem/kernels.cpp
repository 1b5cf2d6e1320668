#include "worker/dem/kernels.h"

#include <vector>

namespace granary::dem {

extern const Kernels kPortableKernels;
#if defined(__x86_64__)
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;
#endif

std::optional<std::size_t> effect_combination(const ContactEffects& effects, bool has_rolling_arm) {
  const bool rolls = effects.rolling_friction && effects.spin && has_rolling_arm;
  for (std::size_t k = 0; k < kEffectCombinationCount; ++k) {
    const ContactEffects& row = kEffectCombinations[k].effects;
    if (row.tangential_history == effects.tangential_history && row.rolling_friction == rolls &&
        row.spin == effects.spin && row.cohesion == effects.cohesion) {
      return k;
    }
  }
  return std::nullopt;
}

std::span<const Kernels* const> available_kernels() {
  static const std::vector<const Kernels*> list = [] {
    std::vector<const Kernels*> found = {&kPortableKernels};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) found.push_back(&kAvx2Kernels);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq")) {
      found.push_back(&kAvx512Kernels);
    }
#endif
    return found;
  }();
  return list;
}

const Kernels& kernels() {
  return *available_kernels().back();
}

}  // namespace granary::dem
