// What runs out of a hopper upstream of x = 0: its mass over time and the flow through the gate,
// with a 95 % interval by blocking. Reads grains, changes nothing.
#pragma once

#include <vector>

#include "worker/core/simulation.h"
#include "worker/dem/grains.h"

namespace granary::measure {

class HopperRecord {
 public:
  explicit HopperRecord(double sample_start) : sample_start_(sample_start) {}

  // One frame; the first one tells how full the hopper was.
  void sample(double time, const dem::GrainTable& grains);

  // Value hopper_flow_kg_per_s: mean over the frames from sample_start on while the hopper holds at
  // least kLeastFill of its first mass; below, the flow follows the fill. Series "hopper".
  void add_to(core::Observation& observation) const;
  static constexpr double kLeastFill = 0.3;

  void save(core::State& state) const;
  void load(const core::State& state);

 private:
  std::size_t steady_end() const;
  std::vector<double> flows() const;  // kg/s, since the frame before; the first is 0

  double sample_start_;
  std::vector<double> times_;  // s
  std::vector<double> mass_;   // kg, of grains with x < 0
};

}  // namespace granary::measure
