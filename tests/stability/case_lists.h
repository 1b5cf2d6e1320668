// The hard cases by engine.
#pragma once

#include "tests/stability/hard_case.h"

namespace granary::stability {

std::vector<HardCase> discharge_cases();
std::vector<HardCase> chute_cases();

}  // namespace granary::stability
