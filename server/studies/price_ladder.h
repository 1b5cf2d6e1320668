// Which settings a price study climbs: ladders of ever finer values around the base scene's own,
// one setting at a time (PHYSICS section D).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "granary/v1/scene.pb.h"
#include "granary/v1/study.pb.h"
#include "proto/contract/result.h"

namespace granary::server {

struct Rung {
  double value = 0;                           // of the ladder's setting
  std::map<std::string, std::string> inputs;  // scene path -> value as text; empty: the base scene
};

struct Ladder {
  std::string path;
  double ratio = 2;         // of the error's h between neighbours: PHYSICS D 2 and D 3
  std::vector<Rung> rungs;  // from coarse to fine; the base scene is one of them
  std::size_t base = 0;
};

// Every trial's scene without what is a study's business: accuracy, seeds of its own; effects as
// the base scene has them, replicates as the study asks.
struct PricePlan {
  v1::Scene base;
  std::vector<Ladder> ladders;
};

// INVALID_ARGUMENT when the scene is not valid or a ladder is asked for that its kind does not
// have.
Result<PricePlan> plan_price(const v1::StudySpec& spec);

inline constexpr std::uint32_t kDefaultPriceReplicates = 4;

}  // namespace granary::server
