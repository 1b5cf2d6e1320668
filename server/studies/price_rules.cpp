#include "server/studies/price_rules.h"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace granary::server {
namespace {

using Inputs = std::map<std::string, std::string>;

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::function<Inputs(double)> scale_alone(const std::string& path, double value) {
  return [path, value](double factor) { return Inputs{{path, text_of(value * factor)}}; };
}

// ---- size: fewer, larger particles instead of the real ones, to see much for little

LadderRule size_rule(const std::string& path, double diameter) {
  return {.path = path,
          .value = diameter,
          .factor = std::numbers::sqrt2,
          .ratio = std::numbers::sqrt2,
          .rungs = 3,
          .coarser = 2,
          .smallest = 0,
          .largest = 1,
          .screening = true};
}

// The same solid area. A disk's mass goes with d^2, so K h^2 / m stays with a step that goes with
// d.
LadderRule disc_size_rule(const v1::Discharge& d) {
  const auto& particles = d.particles();
  LadderRule rule = size_rule("discharge.particles.diameter_min_m", particles.diameter_min_m());
  rule.cost_power = -3;  // of the count -2, of the steps -1
  rule.inputs = [particles, dt = d.time_step_s(), filling_dt = d.filling_time_step_s()](double f) {
    return Inputs{
        {"discharge.particles.diameter_min_m", text_of(particles.diameter_min_m() * f)},
        {"discharge.particles.diameter_max_m", text_of(particles.diameter_max_m() * f)},
        {"discharge.particles.count", std::to_string(std::lround(particles.count() / (f * f)))},
        {"discharge.time_step_s", text_of(dt * f)},
        {"discharge.filling_time_step_s", text_of(filling_dt * f)}};
  };
  return rule;
}

// The same feed by mass and the same solid volume at the start; the step goes with the contact
// time, (m / k)^1/2.
LadderRule sphere_size_rule(const v1::Chute& c) {
  LadderRule rule = size_rule("chute.particles[0].diameter_m", c.particles(0).diameter_m());
  rule.cost_power = -4.5;  // of the count -3, of the steps -1.5
  std::vector<double> diameters;
  for (const v1::SphereClass& each : c.particles()) diameters.push_back(each.diameter_m());
  rule.inputs = [diameters, dt = c.time_step_s(), count = c.initial_count()](double f) {
    Inputs inputs{{"chute.time_step_s", text_of(dt * std::pow(f, 1.5))}};
    for (std::size_t i = 0; i < diameters.size(); ++i)
      inputs["chute.particles[" + std::to_string(i) + "].diameter_m"] = text_of(diameters[i] * f);
    if (count > 0) inputs["chute.initial_count"] = std::to_string(std::lround(count / (f * f * f)));
    return inputs;
  };
  return rule;
}

// ---- by kind of scene

std::vector<LadderRule> discharge_rules(const v1::Discharge& d) {
  const std::string step = "discharge.time_step_s";
  const std::string penalty = "discharge.penalty.stiffness_n_per_m";
  const std::string tolerance = "discharge.solver.tolerance";
  const double dt = d.time_step_s(), filling_dt = d.filling_time_step_s();
  std::vector<LadderRule> rules = {
      {.path = step,
       .value = dt,
       .smallest = 1e-7,
       .largest = 0.01,
       .cost_power = -1,
       .inputs =
           [step, dt, filling_dt](double factor) {
             return Inputs{{step, text_of(dt * factor)},
                           {"discharge.filling_time_step_s", text_of(filling_dt * factor)}};
           }},
      {.path = penalty,
       .value = d.penalty().stiffness_n_per_m(),
       .factor = 10,
       .ratio = 10,
       .finer_is_larger = true,
       .rungs = 4,
       .smallest = 1,
       .largest = 1e13,
       .cost_power = 0.5,
       .inputs = scale_alone(penalty, d.penalty().stiffness_n_per_m())},
      {.path = tolerance,
       .value = d.solver().tolerance(),
       .factor = 3,
       .ratio = 3,
       .rungs = 4,
       .coarser = 1,
       .smallest = 1e-9,
       .largest = 1,
       .inputs = scale_alone(tolerance, d.solver().tolerance())}};
  const bool filled_by_count =
      d.filling() == v1::Discharge::DROP || d.filling() == v1::Discharge::ORDERED_COMPACT;
  if (filled_by_count && d.particles().count() > 0 && d.particles().diameter_min_m() > 0)
    rules.push_back(disc_size_rule(d));
  return rules;
}

std::vector<LadderRule> chute_rules(const v1::Chute& c) {
  const std::string step = "chute.time_step_s";
  const std::string stiffness = "chute.contact_pp.normal_stiffness_n_per_m";
  const double dt = c.time_step_s();
  const double pp = c.contact_pp().normal_stiffness_n_per_m();
  const double pw = c.contact_pw().normal_stiffness_n_per_m();
  std::vector<LadderRule> rules = {
      {.path = step,
       .value = dt,
       .smallest = 1e-9,
       .largest = 0.01,
       .cost_power = -1,
       .inputs = scale_alone(step, dt)},
      // The step follows the contact time; the model error goes with k^-1/2.
      {.path = stiffness,
       .value = pp,
       .factor = 4,
       .ratio = 2,
       .finer_is_larger = true,
       .rungs = 3,
       .coarser = 1,
       .smallest = 1,
       .largest = 1e10,
       .cost_power = 0.5,
       .inputs = [step, stiffness, dt, pp, pw](double factor) {
         return Inputs{{stiffness, text_of(pp * factor)},
                       {"chute.contact_pw.normal_stiffness_n_per_m", text_of(pw * factor)},
                       {step, text_of(dt / std::sqrt(factor))}};
       }}};
  const bool fed = c.inlet().feed() != v1::Inlet::NONE || c.initial_count() > 0;
  if (fed && c.particles_size() > 0) rules.push_back(sphere_size_rule(c));
  return rules;
}

}  // namespace

std::vector<LadderRule> ladder_rules(const v1::Scene& resolved) {
  return resolved.has_chute() ? chute_rules(resolved.chute())
                              : discharge_rules(resolved.discharge());
}

}  // namespace granary::server
