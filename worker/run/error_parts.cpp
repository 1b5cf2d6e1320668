#include "worker/run/error_parts.h"

#include <cmath>
#include <cstdio>

namespace granary::run {

double combined(const ErrorParts& parts, double sampling) {
  return std::sqrt(parts.discretisation * parts.discretisation + parts.stiffness * parts.stiffness +
                   parts.solver * parts.solver + sampling * sampling);
}

void add_error_parts(std::vector<core::ObservedValue>& values,
                     const std::map<std::string, ErrorParts>& parts) {
  for (core::ObservedValue& value : values) {
    const auto found = parts.find(value.name);
    if (found == parts.end() || !value.value || !value.error) continue;
    const double sampling = found->second.sampling.value_or(*value.error);
    char text[160];
    std::snprintf(text, sizeof text,
                  "95 %%: discretisation %.2g, stiffness %.2g, solver %.2g, sampling %.2g (%s",
                  found->second.discretisation, found->second.stiffness, found->second.solver,
                  sampling, found->second.sampling ? "spread of all pilots; " : "");
    value.error = combined(found->second, sampling);
    value.error_basis = text + value.error_basis + ")";
  }
}

}  // namespace granary::run
