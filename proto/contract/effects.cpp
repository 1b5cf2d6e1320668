#include "proto/contract/effects.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace granary {
namespace {

using Mode = v1::Effects::Mode;

struct Numbers {
  std::optional<double> number;
  std::optional<double> threshold;
  std::optional<double> omitted_error;  // relative, if switched off; absent = no bound known
  bool wanted = true;                   // what AUTO decides
  std::string reason;
};

v1::EffectReport report(bool said, Mode mode, const Numbers& numbers) {
  v1::EffectReport out;
  const bool by_user = said && mode != v1::Effects::AUTO;
  out.set_on(by_user ? mode == v1::Effects::ON : numbers.wanted);
  out.set_chosen_by(by_user ? "user" : "auto");
  if (numbers.number) out.set_number(*numbers.number);
  if (numbers.threshold) out.set_threshold(*numbers.threshold);
  if (out.on())
    out.set_omitted_error(0);
  else if (numbers.omitted_error)
    out.set_omitted_error(*numbers.omitted_error);
  out.set_reason(numbers.reason);
  return out;
}

double target_of(const v1::Scene& scene) {
  return scene.accuracy().has_target() ? scene.accuracy().target() : kDefaultAccuracyTarget;
}

// --------------------------------------------------------------------------------------- discharge

// Range lost in flight ~ 0.45 (v/vt)^2 for the impact speed v; here v = throw speed at the tip and
// the fall of one pulley radius, for the smallest disk as a sphere.
Numbers discharge_gas(const v1::Discharge& d, double target) {
  const double tip = d.pulley_radius_m() - d.bucket().tip_x_m();
  const double omega = d.has_rotation_rad_per_s() ? d.rotation_rad_per_s()
                                                  : std::sqrt(d.rademacher_ka() * 9.81 / tip);
  const double speed2 = std::pow(omega * tip, 2) + 2 * d.gravity_m_per_s2() * d.pulley_radius_m();
  double diameter = d.particles().diameter_min_m();
  if (diameter <= 0 && d.discs_size() > 0) diameter = d.discs(0).diameter_m();
  const double vt = terminal_velocity(diameter, d.particles().density_kg_per_m3(),
                                      d.air_density_kg_per_m3(), d.air_viscosity_pa_s(), 9.81);
  Numbers n;
  n.number = vt > 0 ? 0.45 * speed2 / (vt * vt) : 0;
  n.threshold = target;
  n.omitted_error = n.number;
  n.wanted = *n.number > *n.threshold;
  n.reason = "range lost by a lone disk in still air; an upper bound for a compact jet";
  return n;
}

// Friction on the bucket's side cheeks, which a 2-D model cannot have: traction mu K p on two faces
// against the weight of the bed between them, mu K h / depth (PHYSICS section I), with the lateral
// pressure ratio K = 1 - sin(friction) and a mean depth h of half the wall.
Numbers discharge_cheeks(const v1::Discharge& d) {
  const double lateral = 1 - std::sin(d.friction_pp_deg() * M_PI / 180);
  const double wall = std::tan(d.friction_pw_deg() * M_PI / 180);
  Numbers n;
  n.number = wall * lateral * d.bucket().tip_y_m() / 2 / d.particles().axial_depth_m();
  n.threshold = 0.02;
  n.omitted_error = n.number;
  n.wanted = false;
  n.reason = "friction on the side cheeks / weight: not available in two dimensions";
  return n;
}

Numbers discharge_rolling(const v1::Discharge& d) {
  const double tangent = std::tan(d.friction_pw_deg() * M_PI / 180);
  Numbers n;
  n.number = tangent > 0 ? d.rolling_friction_coefficient() / tangent : 0;
  n.threshold = 0.02;
  n.wanted = d.rolling_friction_coefficient() > 0;
  n.omitted_error = n.wanted ? std::nullopt : std::optional<double>(0);
  n.reason = n.wanted ? "mu_r / tan(friction)" : "mu_r = 0";
  return n;
}

Numbers discharge_cohesion(const v1::Discharge& d) {
  const double diameter = d.particles().diameter_min_m();
  const double weight = d.particles().density_kg_per_m3() * M_PI * diameter * diameter / 4 * 9.81;
  Numbers n;
  n.number = weight > 0 ? d.cohesion_n_per_m() / weight : 0;
  n.threshold = 0.1;
  n.wanted = d.cohesion_n_per_m() > 0;
  n.omitted_error = n.wanted ? std::nullopt : std::optional<double>(0);
  n.reason = n.wanted ? "cohesive force / weight of the smallest disk" : "cohesion = 0";
  return n;
}

Numbers always(const char* reason) {
  Numbers n;
  n.reason = reason;
  return n;
}

// ------------------------------------------------------------------------------------------- chute

struct ChuteFlow {
  double exit_speed, theta, omega, wall_friction;
};

// Plug slip with base friction (PHYSICS A6): v^2 = v_in^2 + 2 g (sin - mu cos) L.
ChuteFlow estimate_flow(const v1::Chute& c) {
  ChuteFlow flow;
  flow.theta = c.inclination_deg() * M_PI / 180;
  flow.omega = std::abs(c.rotation_rpm()) * 2 * M_PI / 60;
  flow.wall_friction = c.contact_pw().friction_coefficient();
  double inlet_speed = 0;
  if (c.inlet().has_mass_flow_kg_per_s() && c.inlet().has_sluice_height_m())
    inlet_speed = c.inlet().mass_flow_kg_per_s() / (c.particles(0).density_kg_per_m3() * 0.68 *
                                                    c.width_m() * c.inlet().sluice_height_m());
  const double drive = std::max(
      0.05 * c.gravity_m_per_s2(),
      c.gravity_m_per_s2() * (std::sin(flow.theta) - flow.wall_friction * std::cos(flow.theta)));
  flow.exit_speed = std::sqrt(inlet_speed * inlet_speed + 2 * drive * c.length_m());
  return flow;
}

// min(G, B): G = g L / (2 vt^2), the loss of one grain in still air; B = rho_g A v / (2 Q), what
// the momentum of the air above a dense bed can take at most.
Numbers chute_gas(const v1::Chute& c, double target) {
  const ChuteFlow flow = estimate_flow(c);
  const double vt =
      terminal_velocity(c.particles(0).diameter_m(), c.particles(0).density_kg_per_m3(),
                        c.gas().density_kg_per_m3(), c.gas().viscosity_pa_s(), 9.81);
  double bound = c.gravity_m_per_s2() * c.length_m() / (2 * vt * vt);
  if (c.inlet().mass_flow_kg_per_s() > 0)
    bound = std::min(bound, c.gas().density_kg_per_m3() * c.width_m() * c.depth_m() *
                                flow.exit_speed / (2 * c.inlet().mass_flow_kg_per_s()));
  Numbers n;
  n.number = bound;
  n.threshold = target;
  n.omitted_error = bound;
  n.wanted = false;
  n.reason = bound > target ? "loss of exit speed above the threshold, but not available"
                            : "loss of exit speed: single grain in still air or momentum bound";
  return n;
}

Numbers chute_frame(const v1::Chute& c) {
  const ChuteFlow flow = estimate_flow(c);
  Numbers n;
  n.number = std::atan(2 * flow.omega * flow.exit_speed / c.gravity_m_per_s2()) * 180 / M_PI;
  n.threshold = 2;
  n.wanted =
      flow.omega > 0;  // the exact answer costs little, so only a chute at rest leaves it out
  n.omitted_error = flow.omega > 0 ? std::nullopt : std::optional<double>(0);
  n.reason =
      flow.omega > 0 ? "Coriolis tilt of the free surface in degrees" : "the chute does not rotate";
  return n;
}

Numbers chute_rolling(const v1::Chute& c) {
  const double mu_r = std::max(c.contact_pp().rolling_friction_coefficient(),
                               c.contact_pw().rolling_friction_coefficient());
  const double tangent = std::tan(c.inclination_deg() * M_PI / 180);
  Numbers n;
  n.number = tangent > 0 ? mu_r / tangent : mu_r;
  n.threshold = 0.02;
  n.wanted = mu_r > 0;
  n.omitted_error = n.wanted ? std::nullopt : std::optional<double>(0);
  n.reason = n.wanted ? "mu_r / tan(inclination)" : "mu_r = 0";
  return n;
}

Numbers chute_rotation(const v1::Chute& c) {
  Numbers n = always("tan(inclination) / (3.5 mu_pw): grains roll below 1; no bound, stays on");
  const double mu = c.contact_pw().friction_coefficient();
  if (mu > 0) n.number = std::tan(c.inclination_deg() * M_PI / 180) / (3.5 * mu);
  n.threshold = 1;
  return n;
}

Numbers chute_history(const v1::Chute& c) {
  const auto& pp = c.contact_pp();
  Numbers n = always("stick limit (7/2) mu (1 + e_n) / (1 + e_t) of vc/vn; no bound, stays on");
  n.number = 3.5 * pp.friction_coefficient() * (1 + pp.normal_restitution()) /
             (1 + pp.tangential_restitution());
  return n;
}

Numbers chute_cohesion(const v1::Chute& c) {
  Numbers n;
  n.number = c.cohesion_bond();
  n.threshold = 0.1;
  n.wanted = c.cohesion_bond() > 0;
  n.omitted_error = n.wanted ? std::nullopt : std::optional<double>(0);
  n.reason = n.wanted ? "cohesive force / weight" : "cohesion = 0";
  return n;
}

}  // namespace

double terminal_velocity(double diameter_m, double density, double gas_density, double viscosity,
                         double gravity) {
  if (diameter_m <= 0 || gas_density <= 0 || viscosity <= 0) return 0;
  double speed = density * gravity * diameter_m * diameter_m / (18 * viscosity);
  for (int i = 0; i < 200; ++i) {  // damped fixed point; 200 halvings are far below rounding
    const double reynolds = std::max(1e-12, gas_density * speed * diameter_m / viscosity);
    const double drag =
        reynolds < 1000 ? 24 / reynolds * (1 + 0.15 * std::pow(reynolds, 0.687)) : 0.44;
    const double next = std::sqrt(4 * density * gravity * diameter_m / (3 * gas_density * drag));
    speed = 0.5 * (speed + next);
  }
  return speed;
}

std::map<std::string, v1::EffectReport> decide_effects(const v1::Scene& scene) {
  const v1::Effects& e = scene.effects();
  std::map<std::string, v1::EffectReport> out;
  const auto put = [&](const char* name, bool said, Mode mode, const Numbers& numbers) {
    out[name] = report(said, mode, numbers);
  };
  if (scene.has_discharge()) {
    const v1::Discharge& d = scene.discharge();
    put("gas", e.has_gas(), e.gas(), discharge_gas(d, target_of(scene)));
    put("rotating_frame", e.has_rotating_frame(), e.rotating_frame(),
        always("the bucket's walls move"));
    put("rolling_friction", e.has_rolling_friction(), e.rolling_friction(), discharge_rolling(d));
    put("particle_rotation", e.has_particle_rotation(), e.particle_rotation(),
        always("no bound, stays on"));
    put("tangential_history", e.has_tangential_history(), e.tangential_history(),
        always("resting contacts in the filling need it"));
    put("cohesion", e.has_cohesion(), e.cohesion(), discharge_cohesion(d));
    put("side_cheek_friction", false, v1::Effects::AUTO, discharge_cheeks(d));
  } else {
    const v1::Chute& c = scene.chute();
    put("gas", e.has_gas(), e.gas(), chute_gas(c, target_of(scene)));
    put("rotating_frame", e.has_rotating_frame(), e.rotating_frame(), chute_frame(c));
    put("rolling_friction", e.has_rolling_friction(), e.rolling_friction(), chute_rolling(c));
    put("particle_rotation", e.has_particle_rotation(), e.particle_rotation(), chute_rotation(c));
    put("tangential_history", e.has_tangential_history(), e.tangential_history(), chute_history(c));
    put("cohesion", e.has_cohesion(), e.cohesion(), chute_cohesion(c));
  }
  return out;
}

}  // namespace granary
