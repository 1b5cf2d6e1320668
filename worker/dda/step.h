// One time step (PHYSICS section F): the penalty problem, by impulses or by open-close iteration,
// in one of three integrators (integrators.h). Disks without any contact fly their exact parabola
// at any step.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

void step(System& system);

}  // namespace granary::dda
