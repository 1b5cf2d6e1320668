// What the error of a value consists of besides sampling, when pilots have found out.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "worker/core/simulation.h"

namespace granary::run {

// Half-widths of 95 % intervals, in the unit of the value.
struct ErrorParts {
  double discretisation = 0;  // time step
  double stiffness = 0;
  double solver = 0;
  // From the spread of all pilots, which a handful of replicates cannot know; absent: their own.
  std::optional<double> sampling;
};

double combined(const ErrorParts& parts, double sampling);

// Widens the error of every value that has parts; error_basis then names all of them.
void add_error_parts(std::vector<core::ObservedValue>& values,
                     const std::map<std::string, ErrorParts>& parts);

}  // namespace granary::run
