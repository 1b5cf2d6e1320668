// A method that looks for the best point of a unit box, batch by batch. The points of a batch are
// independent of each other, so they can be evaluated in parallel; the next batch follows from the
// scores of all before it and from random numbers that are part of the state.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "granary/v1/study.pb.h"

namespace granary::server {

using Point = std::vector<double>;  // one number in [0, 1] per variable

struct Scored {
  Point point;
  // Larger is better. Points that break a constraint are below kInfeasible, by how much they break
  // it; failed ones are kFailed.
  double merit = 0;
  std::vector<double>
      terms;  // per objective, larger is better, constraints and failures as in merit
};
inline constexpr double kInfeasible = -1e6;
inline constexpr double kFailed = -1e12;

class SearchMethod {
 public:
  virtual ~SearchMethod() = default;

  // Called once everything before has been taken. Never empty.
  virtual std::vector<Point> next_batch() = 0;
  // The scores of the last batch, in its order.
  virtual void take(const std::vector<Scored>& batch) = 0;

  virtual nlohmann::json save() const = 0;
  virtual void restore(const nlohmann::json& state) = 0;  // throws on a state of another kind
};

struct SearchSetup {
  Point start;
  std::size_t terms = 1;
  std::size_t population = 8;  // > 0
  std::uint64_t seed = 1;
};

// `settings.method` decides which.
std::unique_ptr<SearchMethod> make_search(const v1::Optimize& settings, const SearchSetup& setup);

}  // namespace granary::server
