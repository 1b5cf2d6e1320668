#include "worker/dem/contact_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granary::dem {
namespace {

using core::Vec3;

constexpr double kPi2 = std::numbers::pi * std::numbers::pi;

double log_restitution(double restitution) {
  return std::log(std::max(restitution, kLeastRestitution));
}

// eta = -2 ln e sqrt(m k / (pi^2 + ln^2 e)); e = 0 is critical damping.
double damping(double restitution, double mass, double stiffness) {
  if (restitution == 0) return 2 * std::sqrt(mass * stiffness);
  const double log_e = std::log(restitution);
  return -2 * log_e * std::sqrt(mass * stiffness / (kPi2 + log_e * log_e));
}

// Eq. 10, bounded by the torque that stops the relative spin within this step.
Vec3 rolling_torque(const ContactCoefficients& law, double pressing, const Vec3& spin_after,
                    double time_step) {
  const double rate = norm(spin_after);
  if (rate == 0) return {};
  const double coulomb = law.rolling_arm * std::abs(pressing);
  const double stopping = law.reduced_inertia * rate / time_step;
  return spin_after * (-std::min(coulomb, stopping) / rate);
}

}  // namespace

ContactCoefficients contact_coefficients(const ContactParameters& parameters, double reduced_mass,
                                         bool spin) {
  const double log_n = log_restitution(parameters.normal_restitution);
  const double log_t = log_restitution(parameters.tangential_restitution);
  const double tangential_factor = spin ? 2.0 / 7.0 : 1.0;
  ContactCoefficients law;
  law.normal_stiffness = parameters.normal_stiffness;
  law.tangential_stiffness = tangential_factor * parameters.normal_stiffness *
                             (kPi2 + log_t * log_t) / (kPi2 + log_n * log_n);
  if (parameters.tangential_stiffness > 0) {
    law.tangential_stiffness = parameters.tangential_stiffness;
  }
  law.normal_damping =
      damping(parameters.normal_restitution, reduced_mass, parameters.normal_stiffness);
  law.tangential_damping = damping(parameters.tangential_restitution,
                                   tangential_factor * reduced_mass, law.tangential_stiffness);
  law.friction = parameters.friction;
  return law;
}

double collision_time(const ContactParameters& parameters, double reduced_mass) {
  const double log_n = log_restitution(parameters.normal_restitution);
  return std::sqrt(reduced_mass * (kPi2 + log_n * log_n) / parameters.normal_stiffness);
}

ContactForce evaluate_contact(const ContactGeometry& contact, const ContactCoefficients& law,
                              const ContactEffects& effects, const Vec3& spring_before,
                              double spin_response, double time_step) {
  const Vec3& n = contact.normal;
  const Vec3 sliding = contact.relative_velocity - n * dot(contact.relative_velocity, n);
  const double approach = dot(contact.damped_velocity, n);
  const Vec3 dashpot = (contact.damped_velocity - n * approach) * law.tangential_damping;

  ContactForce force;
  force.damping_normal = law.normal_damping * approach;
  const double pressing = law.normal_stiffness * contact.overlap + force.damping_normal;
  force.normal = effects.cohesion ? pressing - law.cohesion : pressing;

  const double stiffness = effects.tangential_history ? law.tangential_stiffness : 0;
  const Vec3 in_plane = spring_before - n * dot(spring_before, n);
  const Vec3 trial_spring = in_plane + sliding * (time_step * contact.touched_share);
  const Vec3 trial = trial_spring * -stiffness - dashpot;
  const double size = norm(trial);
  const double limit = law.friction * std::abs(pressing);
  const double kept = size > limit ? limit / size : 1;
  force.tangential = trial * kept;
  if (effects.tangential_history) {
    force.spring = kept < 1 ? (force.tangential + dashpot) * (-1 / stiffness) : trial_spring;
    force.slip = trial_spring - force.spring;
  }

  if (effects.rolling_friction && law.rolling_arm > 0) {
    const Vec3 spin_after =
        contact.relative_spin + cross(n, force.tangential) * (spin_response * time_step);
    force.rolling_torque = rolling_torque(law, pressing, spin_after, time_step);
  }
  return force;
}

}  // namespace granary::dem
