// An explicit discrete-element integrator of the same scenes, to compare costs with: the lists,
// narrow phase, vector width, springs, dashpots and friction of worker/dda, but forces from the
// state at the start of each step (semi-implicit Euler). Not a product engine.
#pragma once

#include "worker/dda/system.h"

namespace granary::bench {

// Largest step of a linear contact between two mean disks divided by `parts` (PHYSICS A1): t_c /
// parts.
double contact_time_step(const dda::System& system, double parts);

// One step of system.time_step, cut into whole explicit steps of at most `longest`.
void explicit_step(dda::System& system, double longest);

}  // namespace granary::bench
