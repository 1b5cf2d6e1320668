#include "server/studies/price_ladder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "proto/contract/resolve.h"
#include "server/studies/study_generator.h"

namespace granary::server {
namespace {

constexpr std::uint32_t kMostRungs = 12;

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// One kind of ladder: how the inputs follow from the factor of its setting (finer = factor below 1
// for a step or a tolerance, above 1 for a stiffness).
struct Rule {
  std::string path;
  double value = 0;   // of the base scene
  double factor = 2;  // of the setting between neighbours
  double ratio = 2;   // of h
  bool finer_is_larger = false;
  std::uint32_t rungs = 5;    // when nothing is said
  std::uint32_t coarser = 2;  // of them
  double smallest = 0, largest = 0;
  std::function<std::map<std::string, std::string>(double factor)> inputs;
};

std::vector<Rule> discharge_rules(const v1::Discharge& d) {
  std::vector<Rule> rules;
  const auto plain = [](std::string path, double value) {
    return [path, value](double factor) {
      return std::map<std::string, std::string>{{path, text_of(value * factor)}};
    };
  };
  const double dt = d.time_step_s(), filling_dt = d.filling_time_step_s();
  rules.push_back(
      {"discharge.time_step_s", dt, 2, 2, false, 5, 2, 1e-7, 0.01, [dt, filling_dt](double factor) {
         return std::map<std::string, std::string>{
             {"discharge.time_step_s", text_of(dt * factor)},
             {"discharge.filling_time_step_s", text_of(filling_dt * factor)}};
       }});
  const double stiffness = d.penalty().stiffness_n_per_m();
  rules.push_back({"discharge.penalty.stiffness_n_per_m", stiffness, 10, 10, true, 4, 2, 1, 1e13,
                   plain("discharge.penalty.stiffness_n_per_m", stiffness)});
  const double tolerance = d.solver().tolerance();
  rules.push_back({"discharge.solver.tolerance", tolerance, 3, 3, false, 4, 1, 1e-9, 1,
                   plain("discharge.solver.tolerance", tolerance)});
  return rules;
}

std::vector<Rule> chute_rules(const v1::Chute& c) {
  std::vector<Rule> rules;
  const double dt = c.time_step_s();
  rules.push_back(
      {"chute.time_step_s", dt, 2, 2, false, 5, 2, 1e-9, 0.01, [dt](double factor) {
         return std::map<std::string, std::string>{{"chute.time_step_s", text_of(dt * factor)}};
       }});
  const double pp = c.contact_pp().normal_stiffness_n_per_m();
  const double pw = c.contact_pw().normal_stiffness_n_per_m();
  // The step follows the contact time; the model error goes with k^-1/2.
  rules.push_back({"chute.contact_pp.normal_stiffness_n_per_m", pp, 4, 2, true, 3, 1, 1, 1e10,
                   [dt, pp, pw](double factor) {
                     return std::map<std::string, std::string>{
                         {"chute.contact_pp.normal_stiffness_n_per_m", text_of(pp * factor)},
                         {"chute.contact_pw.normal_stiffness_n_per_m", text_of(pw * factor)},
                         {"chute.time_step_s", text_of(dt / std::sqrt(factor))}};
                   }});
  return rules;
}

Ladder ladder_of(const Rule& rule, const v1::Price& price, const v1::Scene& base) {
  const double given = price.has_ratio() ? price.ratio() : rule.factor;
  const std::uint32_t rungs = price.has_rungs() ? price.rungs() : rule.rungs;
  const std::uint32_t coarser = price.has_rungs() ? (rungs - 1) / 2 : rule.coarser;
  Ladder ladder;
  ladder.path = rule.path;
  ladder.ratio = std::pow(rule.ratio, std::log(given) / std::log(rule.factor));
  for (std::uint32_t k = 0; k < rungs; ++k) {
    const double finer = static_cast<double>(k) - coarser;  // < 0: coarser than the base scene
    const double factor = std::pow(given, rule.finer_is_larger ? finer : -finer);
    const double value = rule.value * factor;
    if (value < rule.smallest || value > rule.largest) continue;
    Rung rung{value, {}};
    if (finer != 0) {
      rung.inputs = rule.inputs(factor);
      auto scene = scene_with(base, rung.inputs);
      if (!scene || !resolve(*scene)) continue;  // too coarse to be stable, for one
    } else {
      ladder.base = ladder.rungs.size();
    }
    ladder.rungs.push_back(std::move(rung));
  }
  return ladder;
}

Status check(const v1::Price& price) {
  if (price.has_rungs() && (price.rungs() < 2 || price.rungs() > kMostRungs))
    return Error{ErrorCode::invalid_argument,
                 "price.rungs: = " + std::to_string(price.rungs()) +
                     " is out of range, must be >= 2 and <= " + std::to_string(kMostRungs),
                 "price.rungs"};
  if (price.has_ratio() && !(price.ratio() > 1 && price.ratio() <= 100))
    return Error{ErrorCode::invalid_argument, "price.ratio: must be > 1 and <= 100", "price.ratio"};
  if (price.has_replicates() && (price.replicates() < 2 || price.replicates() > 100))
    return Error{ErrorCode::invalid_argument,
                 "price.replicates: must be >= 2 and <= 100: a single run has no error bar",
                 "price.replicates"};
  if (price.has_budget_s())
    return Error{ErrorCode::invalid_argument,
                 "price.budget_s: is not available in this version; choose price.rungs and "
                 "price.replicates",
                 "price.budget_s"};
  return Done{};
}

}  // namespace

Result<PricePlan> plan_price(const v1::StudySpec& spec) {
  const v1::Price& price = spec.price();
  if (Status checked = check(price); !checked) return checked.error();
  auto resolved = resolve(spec.scene());
  if (!resolved) return resolved.error();
  PricePlan plan;
  plan.base = spec.scene();
  plan.base.clear_accuracy();
  *plan.base.mutable_effects() = resolved->scene.effects();
  plan.base.set_replicates(price.has_replicates() ? price.replicates() : kDefaultPriceReplicates);
  const std::vector<Rule> rules = resolved->scene.has_chute()
                                      ? chute_rules(resolved->scene.chute())
                                      : discharge_rules(resolved->scene.discharge());
  std::string known;
  for (const Rule& rule : rules) {
    known += (known.empty() ? "" : ", ") + rule.path;
    const auto& asked = price.ladder();
    if (!asked.empty() && std::find(asked.begin(), asked.end(), rule.path) == asked.end()) continue;
    plan.ladders.push_back(ladder_of(rule, price, plan.base));
  }
  for (const std::string& path : price.ladder())
    if (std::none_of(rules.begin(), rules.end(),
                     [&](const Rule& rule) { return rule.path == path; }))
      return Error{ErrorCode::invalid_argument,
                   "price.ladder: has no " + path + ", must be one of " + known, "price.ladder"};
  return plan;
}

}  // namespace granary::server
