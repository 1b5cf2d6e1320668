#include "worker/dem/pair_coefficients.h"

#include <algorithm>

namespace granary::dem {
namespace {

ContactCoefficients between(const EngineSetup& setup, const GrainClass& a, const GrainClass& b) {
  const double reduced_mass = a.mass() * b.mass() / (a.mass() + b.mass());
  ContactCoefficients law =
      contact_coefficients(setup.grain_grain, reduced_mass, setup.effects.spin);
  law.rolling_arm =
      setup.grain_grain.rolling_friction * a.radius * b.radius / (a.radius + b.radius);
  law.reduced_inertia = a.inertia() * b.inertia() / (a.inertia() + b.inertia());
  law.cohesion =
      setup.grain_grain.cohesion_bond * std::min(a.mass(), b.mass()) * norm(setup.motion.gravity);
  return law;
}

ContactCoefficients with_wall(const EngineSetup& setup, const GrainClass& a) {
  ContactCoefficients law = contact_coefficients(setup.grain_wall, a.mass(), setup.effects.spin);
  law.rolling_arm = setup.grain_wall.rolling_friction * a.radius;
  law.reduced_inertia = a.inertia();
  law.cohesion = setup.grain_wall.cohesion_bond * a.mass() * norm(setup.motion.gravity);
  return law;
}

}  // namespace

PairCoefficients pair_coefficients(const EngineSetup& setup) {
  PairCoefficients table;
  for (const GrainClass& a : setup.classes) {
    for (const GrainClass& b : setup.classes) table.grain_grain.push_back(between(setup, a, b));
    table.grain_wall.push_back(with_wall(setup, a));
  }
  return table;
}

}  // namespace granary::dem
