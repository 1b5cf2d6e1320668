#include "server/studies/price_ladder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "proto/contract/resolve.h"
#include "server/studies/price_rules.h"
#include "server/studies/study_generator.h"

namespace granary::server {
namespace {

constexpr std::uint32_t kMostRungs = 12;
constexpr double kLargestBudget_s = 1e8;  // as accuracy.budget_s

std::uint32_t coarser_rungs(const LadderRule& rule, const v1::Price& price, std::uint32_t rungs) {
  if (rule.screening) return rungs - 1;
  return price.has_rungs() ? (rungs - 1) / 2 : rule.coarser;
}

Ladder ladder_of(const LadderRule& rule, const v1::Price& price, const v1::Scene& base) {
  const double given = price.has_ratio() ? price.ratio() : rule.factor;
  const std::uint32_t rungs = price.has_rungs() ? price.rungs() : rule.rungs;
  const std::uint32_t coarser = coarser_rungs(rule, price, rungs);
  Ladder ladder;
  ladder.path = rule.path;
  ladder.ratio = std::pow(rule.ratio, std::log(given) / std::log(rule.factor));
  ladder.screening = rule.screening;
  for (std::uint32_t k = 0; k < rungs; ++k) {
    const double finer = static_cast<double>(k) - coarser;  // < 0: coarser than the base scene
    const double factor = std::pow(given, rule.finer_is_larger ? finer : -finer);
    const double value = rule.value * factor;
    if (value < rule.smallest || value > rule.largest) continue;
    Rung rung{value, {}, std::pow(factor, rule.cost_power)};
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

Status check_range(bool inside, const char* field, double value, const std::string& range) {
  if (inside) return Done{};
  char text[192];
  std::snprintf(text, sizeof text, "%s: = %.6g is out of range, must be %s", field, value,
                range.c_str());
  return Error{ErrorCode::invalid_argument, text, field};
}

Status check(const v1::Price& price) {
  const auto within = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  const Status all[] = {
      check_range(!price.has_rungs() || within(price.rungs(), 2, kMostRungs), "price.rungs",
                  price.rungs(), ">= 2 and <= " + std::to_string(kMostRungs)),
      check_range(!price.has_ratio() || (price.ratio() > 1 && price.ratio() <= 100), "price.ratio",
                  price.ratio(), "> 1 and <= 100"),
      check_range(!price.has_replicates() || within(price.replicates(), 2, 100), "price.replicates",
                  price.replicates(), ">= 2 and <= 100: a single run has no error bar"),
      check_range(!price.has_target() || (price.target() > 0 && price.target() < 1), "price.target",
                  price.target(), "> 0 and < 1 (relative error)"),
      check_range(
          !price.has_budget_s() || (price.budget_s() > 0 && price.budget_s() <= kLargestBudget_s),
          "price.budget_s", price.budget_s(), "> 0 and <= 1e+08 (CPU seconds)")};
  for (const Status& each : all)
    if (!each) return each;
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
  if (price.has_target()) plan.target = price.target();
  if (price.has_budget_s()) plan.budget_s = price.budget_s();
  const std::vector<LadderRule> rules = ladder_rules(resolved->scene);
  std::string known;
  for (const LadderRule& rule : rules) {
    known += (known.empty() ? "" : ", ") + rule.path;
    const auto& asked = price.ladder();
    if (!asked.empty() && std::find(asked.begin(), asked.end(), rule.path) == asked.end()) continue;
    plan.ladders.push_back(ladder_of(rule, price, plan.base));
  }
  for (const std::string& path : price.ladder())
    if (std::none_of(rules.begin(), rules.end(),
                     [&](const LadderRule& rule) { return rule.path == path; }))
      return Error{ErrorCode::invalid_argument,
                   "price.ladder: has no " + path + ", must be one of " + known, "price.ladder"};
  return plan;
}

}  // namespace granary::server
