// What price and ablate studies remember of their trials: values and price, in trial order, as
// data.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/studies/study_generator.h"

namespace granary::server {

struct ShortOutcome {
  struct Value {
    std::optional<double> value, error;
  };
  bool complete = false;
  std::string job;
  std::string error;
  double cpu_s = 0;
  double peak_rss_bytes = 0;
  double ledger_remainder_ratio = 0;
  std::map<std::string, Value> values;
};

class OutcomeList {
 public:
  void add(const TrialOutcome& outcome);
  void add(ShortOutcome outcome) { outcomes_.push_back(std::move(outcome)); }
  std::size_t size() const { return outcomes_.size(); }
  const ShortOutcome& operator[](std::size_t trial) const { return outcomes_[trial]; }

  std::string save() const;  // v1.Trial messages, each behind its length in digits and a newline
  // Throws std::runtime_error on bytes that are not its own.
  void restore(const std::string& bytes);

 private:
  std::vector<ShortOutcome> outcomes_;
};

// Keys of `values` that a kind of scene is mostly asked for.
std::vector<std::string> main_observables(const v1::Scene& scene);

}  // namespace granary::server
