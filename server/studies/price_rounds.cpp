#include "server/studies/price_rounds.h"

#include <algorithm>
#include <cmath>

namespace granary::server {
namespace {

// The coarsest of the finer rungs that is not yet a trial.
const Rung* next_finer(const Ladder& ladder, const PriceTrials& trials) {
  for (std::size_t k = ladder.base + 1; k < ladder.rungs.size(); ++k) {
    bool tried = false;
    for (std::size_t t = 0; t < trials.size(); ++t)
      tried = tried || trials[t].rung == &ladder.rungs[k];
    if (!tried) return &ladder.rungs[k];
  }
  return nullptr;
}

bool meets_target(const PricePlan& plan, const PriceTrials& trials, const Ladder& ladder,
                  const std::string& observable) {
  if (!plan.target) return false;
  const auto error = base_error(trials, ladder, observable);
  return error && error->total <= *plan.target;
}

}  // namespace

bool climbs_in_rounds(const PricePlan& plan) {
  return plan.budget_s || plan.target;
}

std::vector<PriceTrial> first_round(const PricePlan& plan) {
  std::vector<PriceTrial> trials{{}};
  for (const Ladder& ladder : plan.ladders)
    for (std::size_t k = 0; k < ladder.rungs.size(); ++k)
      if (k < ladder.base || (k > ladder.base && !climbs_in_rounds(plan)))
        trials.push_back({&ladder, &ladder.rungs[k]});
  return trials;
}

PriceRound next_round(const PricePlan& plan, const PriceTrials& trials,
                      const std::string& observable) {
  PriceRound round;
  const ShortOutcome* base = trials.base();
  if (!climbs_in_rounds(plan) || base == nullptr) return round;
  double reserved_s = spent_s(trials);
  for (const Ladder& ladder : plan.ladders) {
    const Rung* rung = next_finer(ladder, trials);
    if (rung == nullptr || meets_target(plan, trials, ladder, observable)) continue;
    const double cpu_s = base->cpu_s * rung->cost;
    if (plan.budget_s && reserved_s + cpu_s > *plan.budget_s) {
      round.left_out.push_back({{&ladder, rung}, cpu_s});
      continue;
    }
    reserved_s += cpu_s;
    round.trials.push_back({&ladder, rung});
  }
  return round;
}

double spent_s(const PriceTrials& trials) {
  const OutcomeList& outcomes = trials.outcomes();
  const double base_s = trials.base() != nullptr ? trials.base()->cpu_s : 0;
  double sum_s = 0;
  for (std::size_t t = 0; t < outcomes.size(); ++t)
    sum_s += outcomes[t].complete || trials[t].rung == nullptr ? outcomes[t].cpu_s
                                                               : base_s * trials[t].rung->cost;
  return sum_s;
}

std::optional<RelativeError> base_error(const PriceTrials& trials, const Ladder& ladder,
                                        const std::string& observable) {
  const std::vector<KnownRung> rungs = trials.known(ladder, observable);
  const auto base = std::find_if(rungs.begin(), rungs.end(),
                                 [](const KnownRung& rung) { return rung.rung->inputs.empty(); });
  if (base == rungs.end()) return {};
  const double size = std::abs(base->level.mean);
  return RelativeError{total_error(*base, rungs, judge(ladder, rungs)) / size,
                       sampling_error(*base) / size};
}

}  // namespace granary::server
