// The paper's sequential increase of the penalty (4.1): while contacts overlap by more than the
// tolerance, K grows by a factor, once a step.
//
// Only contacts that carried force at both ends of the step are judged: the overlap v dt of a new
// contact does not depend on K, and would drive it to infinity (PHYSICS section F). Overlaps stay,
// so growth lifts the springs' energy by dK g^2 / 2: booked as its own channel, never hidden.
#pragma once

#include "worker/dda/system.h"

namespace granary::dda {

// Largest penalty that growth may reach: K dt^2 / m of the lightest disk stays below 1e3, where the
// steps are still stable, and K below a hard maximum.
double penalty_cap(const System& system);

// Sets K between two steps and books the energy. Overlaps stay, so normal forces change with K;
// tangential forces stay, so their springs change length.
void change_penalty(System& system, double stiffness);

// Precondition: the step is integrated.
void grow_penalty(System& system);

}  // namespace granary::dda
