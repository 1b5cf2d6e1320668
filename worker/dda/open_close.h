// The classic DDA solver: every contact is open, sticking or sliding; the penalty matrix of those
// states is assembled and solved; contacts that contradict their state change it; until none does
// (open-close iteration, PHYSICS sections A5 and F).
//
// It solves the same step over the same ActiveContacts as the impulse solver: with k = K dt^2,
//   closed    P_n = -k (u_n + bias_n) > 0, else open
//   sticking  P_t = -k (u_t + bias_t) within |P_t| <= mu P_n
//   sliding   P_t = +- mu P_n of the last iteration (the matrix stays symmetric)
// Where both converge they give the same velocities. A step that still changes states at
// `max_sweeps` is taken as it is and counted in `unconverged_steps`.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

// Precondition: the loads are in the velocities (add_loads).
void solve_open_close(System& system);

}  // namespace granary::dda
