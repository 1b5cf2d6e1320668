#include "worker/scene/hopper.h"

#include <algorithm>

namespace granary::scene {
namespace {

using core::Vec3;

// The gate is higher than any fill can lean against it, in lengths + heights of the hopper, and
// reaches this many diameters into the side walls and the floor.
constexpr double kGateHeight = 4;
constexpr double kMargin = 1;

// At x = 0.
void add_panel(std::vector<dem::Triangle>& gate, double y0, double y1, double z0, double z1) {
  gate.push_back({{0, y0, z0}, {0, y1, z0}, {0, y1, z1}});
  gate.push_back({{0, y1, z1}, {0, y0, z1}, {0, y0, z0}});
}

}  // namespace

Hopper hopper_of(const v1::Chute& chute) {
  const v1::Inlet& inlet = chute.inlet();
  const double width = chute.width_m(), slot = inlet.hopper_opening_m();
  double diameter = 0;
  for (const auto& particle : chute.particles())
    diameter = std::max(diameter, particle.diameter_m());
  const double margin = kMargin * diameter;
  const double top = kGateHeight * (inlet.hopper_height_m() + inlet.hopper_length_m());
  Hopper hopper;
  hopper.length = inlet.hopper_length_m();
  hopper.back = {{-hopper.length, 0, 0}, {1, 0, 0}};
  hopper.shut = {{0, 0, 0}, {-1, 0, 0}};
  add_panel(hopper.gate, -margin, width + margin, slot, top);
  const double side = 0.5 * (width - inlet.hopper_opening_width_m());
  if (inlet.has_hopper_opening_width_m() && side > 0) {
    add_panel(hopper.gate, -margin, side, -margin, slot);
    add_panel(hopper.gate, width - side, width + margin, -margin, slot);
  }
  return hopper;
}

}  // namespace granary::scene
