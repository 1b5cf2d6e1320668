#include "proto/contract/placement_rules.h"

#include <algorithm>
#include <cmath>

#include "proto/contract/rule_text.h"

namespace granary {
namespace {

// Deeper overlaps are no contacts: their energy would throw the bodies out.
constexpr double kDeepestPlacement = 0.5;  // radii of the smaller one

double overlap_in_radii(const Placed& a, const Placed& b) {
  const double distance =
      std::hypot(a.centre[0] - b.centre[0], a.centre[1] - b.centre[1], a.centre[2] - b.centre[2]);
  return (a.radius + b.radius - distance) / std::min(a.radius, b.radius);
}

}  // namespace

// Sorted along x, a body is compared with those whose left end lies before its right end.
std::optional<Error> check_placement(const std::string& list, std::vector<Placed> bodies) {
  const auto left = [](const Placed& body) { return body.centre[0] - body.radius; };
  std::sort(bodies.begin(), bodies.end(),
            [&](const Placed& a, const Placed& b) { return left(a) < left(b); });
  for (std::size_t a = 0; a < bodies.size(); ++a)
    for (std::size_t b = a + 1;
         b < bodies.size() && left(bodies[b]) < bodies[a].centre[0] + bodies[a].radius; ++b) {
      const double overlap = overlap_in_radii(bodies[a], bodies[b]);
      if (overlap <= kDeepestPlacement) continue;
      const auto [low, high] = std::minmax(bodies[a].index, bodies[b].index);
      return refuse(list + "[" + std::to_string(high) + "]",
                    "overlaps " + list + "[" + std::to_string(low) + "] by " + number(overlap) +
                        " radii of the smaller, must be <= " + number(kDeepestPlacement));
    }
  return {};
}

}  // namespace granary
