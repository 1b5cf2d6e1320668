// Which points no other point beats in everything.
#pragma once

#include <cstddef>
#include <vector>

namespace granary::server {

// Indices of the non-dominated points, ascending; larger is better in every term. Equal points are
// all kept. O(n^2) comparisons: studies have hundreds of candidates.
std::vector<std::size_t> pareto_front(const std::vector<std::vector<double>>& points);

}  // namespace granary::server
