// One time step of the IMPULSE solver (PHYSICS section F): the penalty problem in dual form,
// projected Gauss-Seidel, backward Euler. Disks without any contact fly their exact parabola at any
// step.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

void step(System& system);

}  // namespace granary::dda
