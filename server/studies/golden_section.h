// Golden sections for a maximum of f(t) on [low, high], as data: which points to look at, and the
// bracket after a comparison. A point that stays inside keeps its exact value, so it is evaluated
// once.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

namespace granary::server {

struct GoldenSection {
  double low = 0, high = 1;
  double left = 0, right = 0;  // interior points, left < right
};

GoldenSection golden_section(double low, double high);
GoldenSection narrowed(const GoldenSection& bracket, bool left_is_better);

// The next points to evaluate, at most `count`: first those the search needs, then those it will
// need whichever way the comparisons go (speculative, for more than one worker). `known`: t ->
// f(t).
std::vector<double> next_points(const GoldenSection& bracket, const std::map<double, double>& known,
                                std::size_t count);

}  // namespace granary::server
