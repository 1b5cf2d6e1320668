#include "proto/contract/contact_effects.h"

#include <algorithm>

namespace granary {
namespace {

constexpr ContactEffectSet kCombinations[] = {
    {},
    {.cohesion = true},
    {.rolling_friction = true},
    {.cohesion = true, .rolling_friction = true},
    {.tangential_history = false},
    {.particle_rotation = false},
    {.particle_rotation = false, .cohesion = true},
    {.particle_rotation = false, .tangential_history = false},
};

bool takes_small_steps(const v1::Solver& solver) {
  return solver.method() == v1::Solver::IMPULSE &&
         solver.integrator() == v1::Solver::BACKWARD_EULER;
}

// One solve per step (OPEN_CLOSE, Newmark) knows friction with history, with or without spin.
bool knows_one_solve(const ContactEffectSet& effects) {
  return effects.tangential_history && !effects.cohesion && !effects.rolling_friction;
}

bool is_on(v1::Effects::Mode mode, bool automatic) {
  return mode == v1::Effects::AUTO ? automatic : mode == v1::Effects::ON;
}

}  // namespace

std::span<const ContactEffectSet> contact_combinations() {
  return kCombinations;
}

ContactEffectSet contact_effects(const v1::Scene& scene) {
  const v1::Effects& e = scene.effects();
  const v1::Discharge& d = scene.discharge();
  return {.particle_rotation = is_on(e.particle_rotation(), true),
          .tangential_history = is_on(e.tangential_history(), true),
          .cohesion = is_on(e.cohesion(), d.cohesion_n_per_m() > 0),
          .rolling_friction = is_on(e.rolling_friction(), d.rolling_friction_coefficient() > 0)};
}

std::string to_string(const ContactEffectSet& effects) {
  std::string text;
  const auto name = [&](bool on, std::string_view effect) {
    if (!on) return;
    if (!text.empty()) text += " + ";
    text += effect;
  };
  name(effects.particle_rotation, "particle_rotation");
  name(effects.tangential_history, "tangential_history");
  name(effects.cohesion, "cohesion");
  name(effects.rolling_friction, "rolling_friction");
  return text.empty() ? "none" : text;
}

Status check_contact_effects(const v1::Scene& scene) {
  const v1::Solver& solver = scene.discharge().solver();
  if (solver.integrator() != v1::Solver::BACKWARD_EULER &&
      scene.discharge().normal_restitution() > 0)
    return Error{ErrorCode::invalid_argument,
                 "discharge.normal_restitution: must be 0 with integrator " +
                     v1::Solver::Integrator_Name(solver.integrator()) +
                     ", which has a rebound of its own; BACKWARD_EULER holds the asked one",
                 "discharge.normal_restitution"};
  const ContactEffectSet wanted = contact_effects(scene);
  const bool all_laws = takes_small_steps(solver);
  std::string valid;
  for (const ContactEffectSet& combination : kCombinations) {
    if (!all_laws && !knows_one_solve(combination)) continue;
    if (combination == wanted) return Done{};
    valid += (valid.empty() ? "" : "; ") + to_string(combination);
  }
  return Error{ErrorCode::invalid_argument,
               "effects: " + to_string(wanted) + " is not built for solver " +
                   v1::Solver::Method_Name(solver.method()) + " with " +
                   v1::Solver::Integrator_Name(solver.integrator()) + ", must be one of: " + valid,
               "effects"};
}

}  // namespace granary
