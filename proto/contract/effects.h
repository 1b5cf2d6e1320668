// Which effects a scene calls for: the dimensionless numbers of PHYSICS section C, computed before
// the run and compared with the accuracy asked for. An effect without a bound stays on.
#pragma once

#include <map>
#include <string>

#include "granary/v1/result.pb.h"
#include "granary/v1/scene.pb.h"

namespace granary {

inline constexpr double kDefaultAccuracyTarget = 0.01;

// Precondition: defaults are filled in. Keys: gas, rotating_frame, rolling_friction,
// particle_rotation, tangential_history, cohesion; of a discharge also side_cheek_friction, which no
// scene can switch on.
std::map<std::string, v1::EffectReport> decide_effects(const v1::Scene& scene);

// Terminal velocity [m/s] of a sphere in still gas, Schiller-Naumann drag (PHYSICS A4).
double terminal_velocity(double diameter_m, double density, double gas_density, double viscosity,
                         double gravity);

}  // namespace granary
