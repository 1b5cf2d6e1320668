// The IMPULSE solver's default way through a step: lists and normals are found once, then the step
// is cut into small ones (K h^2 / m about 1) with one or two sweeps each. The penalty springs are
// then nearly resolved in time, so a sweep that starts from the impulses of the small step before
// is as good as converged, and the error of backward Euler falls with h instead of the step.
//
// Within a small step, o = overlap at its end, o' at its start:
//   P_n = h max(K o + c (o - o') / h, 0)
//   P_t = clamp(S' - (K h^2 + c_t h) u_t, mu P_n),  S = P_t + c_t h u_t  the spring's part, kept
// c and c_t are the dashpots of the asked restitution. Where a gap closes faster than the
// threshold, Newton's law acts instead, as an impulse in the small step that closes it (PHYSICS
// section I): the rebound then does not depend on how the steps resolve the contact.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

// Solves for the velocities at the end of the step; `shift` holds how far touched disks moved.
void solve_small_steps(System& system);
// Books the contacts of the step in the energy ledger; leaves the springs' parts in impulse_t.
void close_small_steps(System& system);
// Moves the disks to the end of the step: touched ones by their shift, the others on their
// parabola.
void integrate_small_steps(System& system);

}  // namespace granary::dda
