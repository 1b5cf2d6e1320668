// Projected Gauss-Seidel over the active contacts: warm start, then sweeps until the impulses
// change by less than the tolerance. Disk pairs first, walls last, so that walls yield least.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

// Precondition: the loads are in the velocities. Solves for the velocities of the step.
void solve_impulses(System& system);

// Writes the contact forces back to the candidate lists, for the next step.
void keep_forces(System& system);

}  // namespace granary::dda
