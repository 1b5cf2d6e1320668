// Which settings a price study climbs: ladders of ever finer values around the base scene's own,
// one setting at a time (PHYSICS section D), and one of coarser particles for screening.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "granary/v1/scene.pb.h"
#include "granary/v1/study.pb.h"
#include "proto/contract/result.h"

namespace granary::server {

struct Rung {
  double value = 0;                           // of the ladder's setting
  std::map<std::string, std::string> inputs;  // scene path -> value as text; empty: the base scene
  double cost = 1;                            // predicted CPU seconds / the base scene's
};

struct Ladder {
  std::string path;
  double ratio = 2;         // of the error's h between neighbours: PHYSICS D 2 and D 3
  bool screening = false;   // no h -> 0: other particles, compared with the base scene's alone
  std::vector<Rung> rungs;  // from coarse to fine; the base scene is one of them
  std::size_t base = 0;
};

// Every trial's scene without what is a study's business: accuracy, seeds of its own; effects as
// the base scene has them, replicates as the study asks.
struct PricePlan {
  v1::Scene base;
  std::vector<Ladder> ladders;
  std::optional<double> target;    // relative error at which a ladder is climbed no further
  std::optional<double> budget_s;  // CPU seconds of the whole study
};

// INVALID_ARGUMENT when the scene is not valid, a ladder is asked for that its kind does not have,
// or a setting of the study is out of its range.
Result<PricePlan> plan_price(const v1::StudySpec& spec);

inline constexpr std::uint32_t kDefaultPriceReplicates = 4;

}  // namespace granary::server
