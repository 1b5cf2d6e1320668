// Time integrators of M a + F_contact = F over one unknown, the mean velocity w = (x+ - x) / dt
// (PHYSICS section F; Newmark family, bucket-elevator paper 2.1):
//
//   backward_euler     c = 1   v+ = w         M w   = M v + dt F+
//   newmark_dda        c = 2   v+ = 2 w - v   2 M w = 2 M v + dt F+         beta 1/2, gamma 1
//   newmark_trapezoid  c = 4   v+ = 2 w - v   4 M w = 4 M v + dt (F + F+)   beta 1/4, gamma 1/2
//
// F = forces at the start, F+ = at the end of the step. The contact solvers see masses c M and
// loads, and need not know which integrator they serve.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

double mass_factor(Integrator integrator);  // c

// Share of the start's contact force in the force that does the step's work.
double start_force_share(Integrator integrator);

// Keeps the velocities at the start of the step and turns masses into c M.
void begin_integration(System& system);

// Adds gravity, and the contact forces of the start where the integrator has them, to the
// velocities. Precondition: the contacts are selected.
void add_loads(System& system);

// Keeps the contact forces at the end of the step as accelerations, for the next step.
void keep_contact_accelerations(System& system);

}  // namespace granary::dda
