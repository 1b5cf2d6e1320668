// CMA-ES and NSGA-II of pagmo, a generation at a time. pagmo calls the fitness itself; so each
// generation runs twice from the same state: once on a copy that only writes down which points it
// would evaluate, once for real when their scores are known. Both runs draw the same random
// numbers, because within a generation neither algorithm looks at a new fitness before all points
// are made.
#pragma once

#include "server/studies/random_stream.h"
#include "server/studies/search_method.h"

namespace granary::server {

class PagmoSearch : public SearchMethod {
 public:
  // Precondition: method is CMA_ES or NSGA_II; NSGA_II: population a multiple of 4, at least 8.
  PagmoSearch(v1::Optimize::Method method, const SearchSetup& setup);
  ~PagmoSearch() override;

  std::vector<Point> next_batch() override;
  void take(const std::vector<Scored>& batch) override;
  nlohmann::json save() const override;
  void restore(const nlohmann::json& state) override;

 private:
  struct State;  // keeps pagmo out of this header: it costs 10 s to compile
  std::unique_ptr<State> state_;
};

}  // namespace granary::server
