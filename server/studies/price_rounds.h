// Which trials of a price study come next. Without budget and target all at once; with one of them
// in rounds: first the base scene and everything coarser, then the next finer rung of each ladder
// that still needs one and fits. A round depends on nothing but the outcomes of those before.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/studies/price_trials.h"

namespace granary::server {

struct LeftOut {
  PriceTrial trial;
  double cpu_s = 0;  // predicted
};

struct PriceRound {
  std::vector<PriceTrial> trials;  // empty: the study ends here
  std::vector<LeftOut> left_out;   // for the budget
};

bool climbs_in_rounds(const PricePlan& plan);
std::vector<PriceTrial> first_round(const PricePlan& plan);
// Precondition: every trial has been told. `observable` is what the target is about.
PriceRound next_round(const PricePlan& plan, const PriceTrials& trials,
                      const std::string& observable);

// CPU seconds of what was told; a failed trial counts as much as it was expected to.
double spent_s(const PriceTrials& trials);

// The base scene's error in one ladder, as a share of its value; nothing while it is not known.
struct RelativeError {
  double total = 0;
  double sampling = 0;  // which no finer rung makes smaller
};
std::optional<RelativeError> base_error(const PriceTrials& trials, const Ladder& ladder,
                                        const std::string& observable);

}  // namespace granary::server
