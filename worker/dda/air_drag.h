// Still air on flying disks, one way: each feels the drag of a lone sphere of its diameter and
// density (Schiller-Naumann; PHYSICS sections C and I). The air is not dragged along and no disk
// shelters another: an upper bound for a compact jet.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/dda/system.h"

namespace granary::dda {

struct StillAir {
  double density = 1.2;        // kg/m3
  double viscosity = 1.81e-5;  // Pa s
  double disk_density = 1000;  // kg/m3
};

// Drag over speed and mass [1/s] of a sphere that moves with `speed` [m/s].
double drag_rate(const StillAir& air, double diameter, double speed);

// Slows the disks marked in `flying` over one step (the rate is frozen at the step's end, so first
// order in dt) and books their loss in the channel `gas`. Spin is left alone.
void slow_flying_disks(System& system, const StillAir& air,
                       const std::vector<std::uint8_t>& flying);

}  // namespace granary::dda
