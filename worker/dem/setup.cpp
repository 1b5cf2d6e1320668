#include "worker/dem/setup.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granary::dem {

double GrainClass::mass() const {
  return density * (4.0 / 3.0) * std::numbers::pi * radius * radius * radius;
}

double GrainClass::inertia() const {
  return 0.4 * mass() * radius * radius;
}

double stable_time_step(const EngineSetup& setup) {
  double lightest = std::numeric_limits<double>::infinity();
  for (const GrainClass& grain_class : setup.classes) {
    lightest = std::min(lightest, grain_class.mass());
  }
  const double stiffness =
      std::max(setup.grain_grain.normal_stiffness, setup.grain_wall.normal_stiffness);
  return 2 / std::sqrt(12 * stiffness / lightest);
}

}  // namespace granary::dem
