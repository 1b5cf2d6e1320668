#include "worker/dda/kernels_body.h"

namespace granary::dda {

extern const Kernels kAvx512Kernels;
const Kernels kAvx512Kernels = {"avx512",
                                select_pairs,
                                apply_impulses,
                                sweep,
                                small_sweep_any<false>,
                                small_sweep_any<true>,
                                close_contacts<false>,
                                close_contacts<true>,
                                advance_disks};

}  // namespace granary::dda
