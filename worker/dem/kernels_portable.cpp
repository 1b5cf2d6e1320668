#include "worker/dem/lanes_portable.h"
// The order matters: the body is written in terms of the lanes.
#include "worker/dem/kernels_body.h"

namespace granary::dem {

extern const Kernels kPortableKernels;
const Kernels kPortableKernels = make_kernels("portable");

}  // namespace granary::dem
