// Means with confidence intervals of few runs.
#pragma once

#include <optional>
#include <span>

namespace granary::server {

struct Mean {
  double value = 0;
  std::optional<double> error;  // half-width of the 95 % interval; unknown for a single run
};

// Student's t over independent runs. Precondition: values is not empty.
Mean mean_of(std::span<const double> values);

// Two-sided 95 % quantile of Student's t.
double student_t_95(std::size_t degrees_of_freedom);

}  // namespace granary::server
