#include "server/studies/pareto.h"

#include <algorithm>

namespace granary::server {
namespace {

bool dominates(const std::vector<double>& a, const std::vector<double>& b) {
  bool better_somewhere = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] < b[i]) return false;
    better_somewhere = better_somewhere || a[i] > b[i];
  }
  return better_somewhere;
}

}  // namespace

std::vector<std::size_t> pareto_front(const std::vector<std::vector<double>>& points) {
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::none_of(points.begin(), points.end(),
                     [&](const auto& other) { return dominates(other, points[i]); }))
      front.push_back(i);
  return front;
}

}  // namespace granary::server
