// Error bars of time averages of correlated samples, by blocking (Flyvbjerg and Petersen 1989;
// PHYSICS section D6), and where the steady state begins (MSER-5, White 1997).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace granary::core {

struct MeanWithError {
  double mean = 0;
  std::optional<double> half_width;  // of the 95 % interval; absent when the record is too short
  std::size_t blocks = 0;            // independent blocks at the level that decided
};

// Half-width = Student's t times the largest standard error over all block lengths that leave at
// least `kMinBlocks` blocks: the plateau when there is one, an upper envelope of its noise otherwise.
inline constexpr std::size_t kMinBlocks = 8;
MeanWithError blocked_mean(std::span<const double> samples);

// Index of the first sample of the steady part: the cut that minimises the marginal standard error
// of the rest, over batches of five; at most half of the record is cut. Absent when the minimum sits
// at that limit (no steady part seen) or there are fewer than 20 samples.
std::optional<std::size_t> steady_from(std::span<const double> samples);

}  // namespace granary::core
