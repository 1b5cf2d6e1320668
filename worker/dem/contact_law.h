// The contact law of the chute paper (Eq. 3-12): linear spring and dashpot along the normal and in
// the tangent plane, Coulomb limit that shortens the tangential spring, rolling resistance. Users
// give restitution coefficients; stiffness and damping follow from them (PHYSICS section A1).
// Signs: a contact is seen from grain a; n points from a to its partner b; overlap > 0 in contact;
// relative velocity = velocity of a minus velocity of b at the contact point.
#pragma once

#include "worker/core/vec3.h"

namespace granary::dem {

// Literature inputs of one kind of contact (grain-grain or grain-wall).
struct ContactParameters {
  double normal_stiffness = 1000;        // N/m
  double normal_restitution = 0.97;      // e_n in [0, 1]
  double tangential_restitution = 0.33;  // e_t in [0, 1]
  double friction = 0.12;                // mu
  double rolling_friction = 0;           // mu_r
  double tangential_stiffness = 0;       // N/m; 0: from the restitution coefficients
  double cohesion_bond = 0;              // attraction while in touch / weight of the lighter grain
};

struct ContactEffects {
  bool tangential_history = true;  // off: dashpot only, still Coulomb-limited
  bool rolling_friction = true;
  bool spin = true;  // off: grains do not turn
  bool cohesion = false;
};

// What a force evaluation needs for one pair of grain classes.
struct ContactCoefficients {
  double normal_stiffness = 0;      // k_n [N/m]
  double tangential_stiffness = 0;  // k_t [N/m]
  double normal_damping = 0;        // eta_n [N s/m]
  double tangential_damping = 0;    // eta_t [N s/m]
  double friction = 0;              // mu
  double cohesion = 0;              // F_c, attraction while in touch [N]
  double rolling_arm = 0;           // mu_r R_r [m], Eq. 12; a wall counts as R_r = R
  double reduced_inertia = 0;       // 1 / (1/I_a + 1/I_b) [kg m^2], bounds the rolling torque
};

// Restitution coefficients are held above this value where the formulas for k_t diverge.
inline constexpr double kLeastRestitution = 1e-3;

// `reduced_mass` m_a m_b / (m_a + m_b), a wall is infinitely heavy. With `spin` the tangential
// inertia is 2/7 of the reduced mass (solid spheres), without it the whole of it (PHYSICS section
// I). rolling_arm and reduced_inertia are left to the caller, who knows the radii.
ContactCoefficients contact_coefficients(const ContactParameters& parameters, double reduced_mass,
                                         bool spin);

// Duration of a binary collision [s]: sqrt(m_eff (pi^2 + ln^2 e_n) / k_n).
double collision_time(const ContactParameters& parameters, double reduced_mass);

struct ContactGeometry {
  core::Vec3 normal;             // unit, from a to b
  double overlap = 0;            // [m]
  core::Vec3 relative_velocity;  // at the contact point, spins included [m/s]
  core::Vec3 damped_velocity;    // what the dashpots see: the same, or carried on to the full step
  double touched_share = 1;      // of the step that led here
  core::Vec3 relative_spin;      // of a relative to b [rad/s]
  double radius_a = 0;
  double radius_b = 0;  // 0 for a wall
};

struct ContactForce {
  double normal = 0;          // along -n on a; > 0 repels [N]
  double damping_normal = 0;  // its dashpot part
  core::Vec3 tangential;      // on a [N]
  core::Vec3 spring;          // tangential elongation after this step [m]
  core::Vec3 slip;            // part of this step's sliding that the spring did not take up [m]
  core::Vec3 rolling_torque;  // on a, minus it on b [N m]
};

// One step of the law. `spin_response` is R_a/I_a - R_b/I_b (b a wall: R_a/I_a): the
// change of relative spin per unit n x F_t, used to stop a rolling torque from reversing it.
ContactForce evaluate_contact(const ContactGeometry& contact, const ContactCoefficients& law,
                              const ContactEffects& effects, const core::Vec3& spring_before,
                              double spin_response, double time_step);

}  // namespace granary::dem
