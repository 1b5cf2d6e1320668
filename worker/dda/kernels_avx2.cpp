#include "worker/dda/kernels_body.h"

namespace granary::dda {

extern const Kernels kAvx2Kernels;
const Kernels kAvx2Kernels = {"avx2", select_pairs, apply_impulses, sweep};

}  // namespace granary::dda
