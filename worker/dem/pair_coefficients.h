// Contact coefficients of every combination of grain classes, and of each class with the walls.
#pragma once

#include <vector>

#include "worker/dem/setup.h"

namespace granary::dem {

struct PairCoefficients {
  std::vector<ContactCoefficients> grain_grain;  // [a * classes + b]
  std::vector<ContactCoefficients> grain_wall;   // [a]
};

PairCoefficients pair_coefficients(const EngineSetup& setup);

}  // namespace granary::dem
