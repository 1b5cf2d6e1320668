// The spec of an optimization, checked and with its defaults filled in; and the way from a point of
// the unit box to a scene.
#pragma once

#include "server/studies/search_method.h"
#include "server/studies/study_generator.h"

namespace granary::server {

struct OptimizeSettings {
  v1::StudySpec spec;  // defaults filled in
  Point start;
  std::vector<bool> whole_numbers;  // per variable

  const v1::Optimize& optimize() const { return spec.optimize(); }
  SearchSetup search_setup() const;
  std::map<std::string, std::string> inputs_at(const Point& point) const;
};

// INVALID_ARGUMENT with the field path.
Result<OptimizeSettings> read_settings(const v1::StudySpec& spec);

}  // namespace granary::server
