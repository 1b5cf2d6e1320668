#include "worker/dda/kernels_body.h"

namespace granary::dda {

extern const Kernels kAvx512Kernels;
const Kernels kAvx512Kernels = {"avx512", select_pairs, apply_impulses, sweep};

}  // namespace granary::dda
