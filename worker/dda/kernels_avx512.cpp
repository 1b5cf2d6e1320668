#include "worker/dda/kernel_table.h"

namespace granary::dda {

extern const Kernels kAvx512Kernels;
constinit const Kernels kAvx512Kernels = make_kernels("avx512");

}  // namespace granary::dda
