// Fills the solver's arrays from the candidate lists: which contacts can act in this step, their
// normals, gap conditions and warm-start impulses.
#pragma once

#include "worker/dda/kernels.h"
#include "worker/dda/system.h"

namespace granary::dda {

// Does the solver cut steps into small ones (small_steps.h)?
bool takes_small_steps(const System& system);

ContactTerms pair_terms(const System& system);
ContactTerms wall_terms(const System& system);
ContactArrays arrays_of(ActiveContacts& contacts);

void select_contacts(System& system);

}  // namespace granary::dda
