// What a ladder of ever finer settings says (PHYSICS section D 7): the same observable at levels h,
// h/r, h/r^2, ..., each the mean of independent runs. Runs of two levels are as independent as
// replicates are (chaos forgets what they had in common), so variances add.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace granary {

// Two-sided 95 % quantile of Student's t; degrees >= 1.
double student_t_95(unsigned degrees);

// Mean of `count` runs with their standard deviation; count >= 1, deviation unknown for one run.
struct LevelMean {
  double mean = 0;
  double deviation = 0;
  unsigned count = 0;
  double variance_of_mean() const { return deviation * deviation / count; }
};
// From a mean and the half-width of its 95 % t-interval over `count` replicates.
LevelMean level_of(double mean, double half_width, unsigned count);

// a - b with the half-width of its 95 % interval (Welch).
struct Difference {
  double value = 0;
  double half_width = 0;
  bool shows() const { return value > half_width || -value > half_width; }
};
Difference difference(const LevelMean& a, const LevelMean& b);

// Levels from coarse to fine, neighbours a factor `ratio` apart.
struct LadderVerdict {
  // p of error ~ h^p, from the three finest levels when both of their differences show and have one
  // sign; absent: below noise.
  std::optional<double> order;
  double limit = 0;             // h -> 0: extrapolated when the order shows, else the finest mean
  double limit_half_width = 0;  // 95 %, what the extrapolation leaves out included
};
LadderVerdict judge_ladder(std::span<const LevelMean> levels, double ratio);

// Bound of |bias| of one level against the limit: what is seen where it shows, else the noise that
// could hide it.
double bias_bound(const LevelMean& level, const LevelMean& finest, const LadderVerdict& verdict);

}  // namespace granary
