#include "worker/dda/kernels_body.h"

namespace granary::dda {

extern const Kernels kPortableKernels;
const Kernels kPortableKernels = {"portable", select_pairs, apply_impulses, sweep};

}  // namespace granary::dda
