#include "worker/dda/kernel_table.h"

namespace granary::dda {

extern const Kernels kPortableKernels;
constinit const Kernels kPortableKernels = make_kernels("portable");

}  // namespace granary::dda
