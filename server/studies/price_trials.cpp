#include "server/studies/price_trials.h"

#include <algorithm>
#include <cmath>

namespace granary::server {

void PriceTrials::append(const std::vector<PriceTrial>& trials) {
  trials_.insert(trials_.end(), trials.begin(), trials.end());
}

const ShortOutcome* PriceTrials::base() const {
  return outcomes_.size() > 0 && outcomes_[0].complete ? &outcomes_[0] : nullptr;
}

const ShortOutcome* PriceTrials::outcome_of(const Ladder& ladder, std::size_t rung) const {
  if (rung == ladder.base) return base();
  const auto found = std::find_if(trials_.begin(), trials_.end(), [&](const PriceTrial& trial) {
    return trial.rung == &ladder.rungs[rung];
  });
  const auto trial = static_cast<std::size_t>(found - trials_.begin());
  return trial < outcomes_.size() && outcomes_[trial].complete ? &outcomes_[trial] : nullptr;
}

std::vector<KnownRung> PriceTrials::known(const Ladder& ladder,
                                          const std::string& observable) const {
  std::vector<KnownRung> rungs;
  if (ladder.screening && base() == nullptr) return rungs;
  for (std::size_t k = 0; k < ladder.rungs.size(); ++k) {
    const ShortOutcome* outcome = outcome_of(ladder, k);
    if (outcome == nullptr) continue;
    const auto found = outcome->values.find(observable);
    if (found == outcome->values.end() || !found->second.value) continue;
    rungs.push_back({&ladder.rungs[k], outcome,
                     level_of(*found->second.value, found->second.error.value_or(0),
                              plan_->base.replicates())});
  }
  return rungs;
}

LadderVerdict judge(const Ladder& ladder, const std::vector<KnownRung>& rungs) {
  if (ladder.screening)
    return {.order = {},
            .limit = rungs.back().level.mean,
            .limit_half_width = sampling_error(rungs.back())};
  std::vector<LevelMean> levels;
  for (const KnownRung& rung : rungs) levels.push_back(rung.level);
  return judge_ladder(levels, ladder.ratio);
}

double sampling_error(const KnownRung& rung) {
  return difference(rung.level, {rung.level.mean, 0, rung.level.count}).half_width;
}

double total_error(const KnownRung& rung, const std::vector<KnownRung>& rungs,
                   const LadderVerdict& verdict) {
  // Nothing finer is known and no order extrapolates: a last difference that shows may still come.
  if (&rung == &rungs.back() && !verdict.order) return verdict.limit_half_width;
  return std::hypot(bias_bound(rung.level, rungs.back().level, verdict), sampling_error(rung));
}

}  // namespace granary::server
