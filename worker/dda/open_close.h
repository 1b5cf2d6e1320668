// The classic DDA solver: every contact is open, sticking or sliding; the penalty matrix of those
// states is assembled and solved; contacts that contradict their state change it; until none does
// (open-close iteration, PHYSICS sections A5 and F).
//
// It solves the same step over the same ActiveContacts as the impulse solver: with k = K dt^2,
//   closed    P_n = -k (u_n + bias_n) > 0, else open
//   sticking  P_t = -k (u_t + bias_t) within the threshold
//   sliding   P_t = +- threshold,  threshold -> mu P_n
// With the thresholds fixed this is the minimum of a convex energy, piecewise quadratic in the
// velocities, and an open-close iteration is a Newton step on it: searching along that step for the
// least energy keeps dense packs from chattering for ever (without it 97 % of their steps do). When
// the states settle, the thresholds follow the normal forces.
//
// The iteration ends when both the momentum that the forces leave unbalanced and the error of the
// friction forces are below the tolerance, relative to the forces. A step that does not get there
// within `max_sweeps` iterations is taken as it is and counted in `unconverged_steps`.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

// Precondition: the loads are in the velocities (add_loads).
void solve_open_close(System& system);

}  // namespace granary::dda
