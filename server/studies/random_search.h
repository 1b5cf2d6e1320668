// Uniform random points: the baseline every method must beat.
#pragma once

#include "server/studies/random_stream.h"
#include "server/studies/search_method.h"

namespace granary::server {

class RandomSearch : public SearchMethod {
 public:
  explicit RandomSearch(const SearchSetup& setup)
      : dimensions_(setup.start.size()), batch_(setup.population), random_(setup.seed) {}

  std::vector<Point> next_batch() override {
    std::vector<Point> batch(batch_, Point(dimensions_));
    for (Point& point : batch)
      for (double& coordinate : point) coordinate = random_.uniform();
    return batch;
  }
  void take(const std::vector<Scored>&) override {}

  nlohmann::json save() const override { return random_.state(); }
  void restore(const nlohmann::json& state) override {
    random_.set_state(state.get<RandomStream::State>());
  }

 private:
  std::size_t dimensions_;
  std::size_t batch_;
  RandomStream random_;
};

}  // namespace granary::server
