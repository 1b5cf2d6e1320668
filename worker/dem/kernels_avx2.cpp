#include "worker/dem/lanes_avx2.h"
// The order matters: the body is written in terms of the lanes.
#include "worker/dem/kernels_body.h"

namespace granary::dem {

extern const Kernels kAvx2Kernels;
const Kernels kAvx2Kernels = make_kernels("avx2");

}  // namespace granary::dem
