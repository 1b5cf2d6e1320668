// The sentences of a price study's verdict, each empty where there is nothing to say.
#pragma once

#include <string>
#include <vector>

#include "server/studies/price_rounds.h"

namespace granary::server {

// What the finest rung has brought beyond the base scene's own.
std::string finest_clause(const Ladder& ladder, const PriceTrials& trials,
                          const std::string& observable);
// Which ladders' error of the base scene is within the target, and which are not.
std::string target_clause(const PricePlan& plan, const PriceTrials& trials,
                          const std::string& observable);
std::string budget_clause(const PricePlan& plan, const PriceTrials& trials,
                          const std::vector<LeftOut>& left_out);
std::string failure_clause(const PricePlan& plan, const PriceTrials& trials);

}  // namespace granary::server
