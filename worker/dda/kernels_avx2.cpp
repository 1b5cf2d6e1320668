#include "worker/dda/kernel_table.h"

namespace granary::dda {

extern const Kernels kAvx2Kernels;
constinit const Kernels kAvx2Kernels = make_kernels("avx2");

}  // namespace granary::dda
