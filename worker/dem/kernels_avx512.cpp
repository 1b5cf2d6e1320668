#include "worker/dem/lanes_avx512.h"
// The order matters: the body is written in terms of the lanes.
#include "worker/dem/kernels_body.h"

namespace granary::dem {

extern const Kernels kAvx512Kernels;
const Kernels kAvx512Kernels = make_kernels("avx512");

}  // namespace granary::dem
