#include "worker/dda/kernels.h"

#include <cstdlib>

namespace granary::dda {

extern const Kernels kPortableKernels;
#if defined(__x86_64__)
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;
#endif

std::size_t available_kernels(const Kernels** list, std::size_t capacity) {
  std::size_t count = 0;
  const auto offer = [&](const Kernels& variant) {
    if (count < capacity) list[count++] = &variant;
  };
  offer(kPortableKernels);
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) offer(kAvx2Kernels);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq"))
    offer(kAvx512Kernels);
#endif
  return count;
}

const ContactKernels& Kernels::laws(const ContactEffects& effects) const {
  const std::size_t index = combination_index(effects);
  if (index == kCombinationCount) std::abort();  // refused when the scene was read
  return combination[index];
}

const Kernels& kernels() {
  static const Kernels& best = []() -> const Kernels& {
    const Kernels* list[3] = {};
    return *list[available_kernels(list, 3) - 1];
  }();
  return best;
}

}  // namespace granary::dda
