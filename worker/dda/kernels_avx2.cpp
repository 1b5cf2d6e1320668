#include "worker/dda/kernels_body.h"

namespace granary::dda {

extern const Kernels kAvx2Kernels;
const Kernels kAvx2Kernels = {"avx2",
                              select_pairs,
                              apply_impulses,
                              sweep,
                              small_sweep_any<false>,
                              small_sweep_any<true>,
                              close_contacts<false>,
                              close_contacts<true>,
                              advance_disks};

}  // namespace granary::dda
