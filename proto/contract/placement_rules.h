// Bodies placed one by one may touch, and overlap a little, but not lie in each other.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "proto/contract/result.h"

namespace granary {

struct Placed {
  std::array<double, 3> centre;
  double radius;
  int index;
};

// `list`: path of the repeated field, named in the refusal. Metres.
std::optional<Error> check_placement(const std::string& list, std::vector<Placed> bodies);

}  // namespace granary
