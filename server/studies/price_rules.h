// Which settings of a scene a price study can climb and what else goes along with each of them
// (PHYSICS section D).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "granary/v1/scene.pb.h"

namespace granary::server {

// One kind of ladder: how the inputs follow from the factor of its setting (finer = factor below 1
// for a step, a tolerance or a size, above 1 for a stiffness).
struct LadderRule {
  std::string path;
  double value = 0;   // of the base scene
  double factor = 2;  // of the setting between neighbours
  double ratio = 2;   // of h
  bool finer_is_larger = false;
  std::uint32_t rungs = 5;    // when nothing is said
  std::uint32_t coarser = 2;  // of them
  double smallest = 0, largest = 0;
  double cost_power = 0;   // CPU seconds go with factor^cost_power
  bool screening = false;  // all rungs are coarser than the base scene or the base scene
  std::function<std::map<std::string, std::string>(double factor)> inputs = {};
};

// The last one is that of sizes, where the scene has it. Precondition: `resolved` is.
std::vector<LadderRule> ladder_rules(const v1::Scene& resolved);

}  // namespace granary::server
