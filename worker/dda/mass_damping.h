// Mass-proportional damping: the matrix C of the paper's Eq. 3 as a rate times M.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

// Slows every disk over one step by exp(-damping_rate dt): exact for a free disk, first order in dt
// beside other forces, and never unstable. The loss goes to the channel normal_damping.
void damp_disks(System& system);

}  // namespace granary::dda
