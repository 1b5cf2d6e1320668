// The trials of a price study as they are proposed, what became of them, and what a ladder's known
// rungs say together.
#pragma once

#include <string>
#include <vector>

#include "proto/contract/ladder.h"
#include "server/studies/outcome_list.h"
#include "server/studies/price_ladder.h"

namespace granary::server {

// Both point into the plan; null: the base scene, which belongs to every ladder.
struct PriceTrial {
  const Ladder* ladder = nullptr;
  const Rung* rung = nullptr;
};

// A rung whose trial has ended well.
struct KnownRung {
  const Rung* rung = nullptr;
  const ShortOutcome* outcome = nullptr;
  LevelMean level;
};

class PriceTrials {
 public:
  explicit PriceTrials(const PricePlan& plan) : plan_(&plan) {}  // must live as long

  void append(const std::vector<PriceTrial>& trials);
  std::size_t size() const { return trials_.size(); }
  const PriceTrial& operator[](std::size_t trial) const { return trials_[trial]; }

  OutcomeList& outcomes() { return outcomes_; }
  const OutcomeList& outcomes() const { return outcomes_; }
  bool all_told() const { return outcomes_.size() == trials_.size(); }

  // Null unless it has ended well.
  const ShortOutcome* base() const;
  // From coarse to fine. Of a screening ladder nothing without the base scene, its only reference.
  std::vector<KnownRung> known(const Ladder& ladder, const std::string& observable) const;

 private:
  const ShortOutcome* outcome_of(const Ladder& ladder, std::size_t rung) const;

  const PricePlan* plan_;
  std::vector<PriceTrial> trials_;
  OutcomeList outcomes_;  // of the first ones
};

// Precondition: not empty.
LadderVerdict judge(const Ladder& ladder, const std::vector<KnownRung>& rungs);

// Half-width of the mean's own 95 % interval.
double sampling_error(const KnownRung& rung);
// Bias against the ladder's limit and sampling together. `rung` is one of `rungs`.
double total_error(const KnownRung& rung, const std::vector<KnownRung>& rungs,
                   const LadderVerdict& verdict);

}  // namespace granary::server
