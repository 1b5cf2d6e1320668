// The hopper feed: a bin upstream of x = 0 between the chute's side walls, as long as the fill is
// meant to be, closed by a back wall and by a gate at x = 0 that leaves a slot above the floor.
#pragma once

#include <vector>

#include "granary/v1/scene.pb.h"
#include "worker/dem/setup.h"

namespace granary::scene {

struct Hopper {
  double length = 0;  // m, from the back wall to the gate
  dem::Plane back;
  dem::Plane shut;                  // the gate while the hopper is filled
  std::vector<dem::Triangle> gate;  // the gate with its slot
};

// Precondition: a resolved chute with feed HOPPER.
Hopper hopper_of(const v1::Chute& chute);

}  // namespace granary::scene
