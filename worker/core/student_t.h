// Student's t distribution for whole degrees of freedom: the error bars of replicates.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace granary::core {

// P(|T| <= t) for `degrees` >= 1. Finite series, Abramowitz & Stegun 26.7.3 and 26.7.4: exact up to
// rounding.
double student_t_two_sided(double t, unsigned degrees);

// t with P(|T| <= t) = probability, 0 < probability < 1.
double student_t_quantile(double probability, unsigned degrees);

struct MeanInterval {
  double mean = 0;
  double half_width = 0;  // of the 95 % interval of the mean
};
// Needs two samples or more.
std::optional<MeanInterval> mean_with_interval(std::span<const double> samples);

}  // namespace granary::core
