// Books one step in the energy ledger, each channel from its own forces (PHYSICS section I).
//
// Exact identities of the step, per contact with force f (end of step), relative displacement
// dt u, stored spring force s at the start: the work f dt u splits into the change of f^2 / 2K, the
// integrator's (f - s)^2 / 2K, and for a sliding contact the friction -f (dt u + (f - s) / K). Per
// touched disk backward Euler dissipates m dv^2 / 2. What does not add up (sweeps that
// stopped at their tolerance) stays in the remainder. The Newmark integrators have no kinetic
// dissipation; with the trapezoid the mean of the forces at start and end does the work, and the
// spring's (f - s)^2 / 2K vanishes too.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

// Starts the balance: stored energies from the disks and the forces in the lists. Overlaps that no
// stored force knows of (disks placed by hand) join the start at the first step.
void open_ledger(System& system);

// The springs' energy as the first step sees it joins the start of the balance.
void start_elastic(System& system, double elastic_at_start);

// Without books (nothing drives the disks: a filling in a bucket at rest) only the stored energies
// are kept. They can but fall: the start of the balance follows them down, step by step, so that
// the remainder adds up all energy that came from nowhere. `remainder` = that before the step [J].
void lower_ledger_start(System& system, double remainder);

// The gap of a contact is linear in the displacements of a step. Where it starts differs from where
// the step before ended, by second order in what the normal turned: the springs' energy changes
// without a displacement, and that is the integrator's doing.
void book_relinearised(System& system, double elastic_at_start);

// Preconditions: solve_impulses is done, `motion_before` holds the velocities at the start.
void book_contacts(System& system);

// Moves the disks to the end of the step and books kinetic, potential and integrator energy.
void integrate(System& system);

}  // namespace granary::dda
