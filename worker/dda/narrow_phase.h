// Fills the solver's arrays from the candidate lists: which contacts can act in this step, their
// normals, gap conditions and warm-start impulses.
#pragma once

#include "worker/dda/kernels.h"
#include "worker/dda/system.h"

namespace granary::dda {

ContactTerms contact_terms(const System& system, double friction);
ContactArrays arrays_of(ActiveContacts& contacts);

void select_contacts(System& system);

}  // namespace granary::dda
