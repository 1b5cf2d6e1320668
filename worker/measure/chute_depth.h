// Profiles over the depth of the bed (PHYSICS section H4): bins of 1.5 mm in height by grain centre,
// in windows along x, over a strip of the width. Solid fraction = grains x volume / bin volume, mean
// over frames, so layering shows; velocity = mean over the grains of all frames.
#pragma once

#include <string>
#include <vector>

#include "worker/core/simulation.h"
#include "worker/dem/grains.h"

namespace granary::measure {

struct DepthWindows {
  double first_x = 0;    // centre of the first window [m]
  double spacing = 0.2;  // between centres
  double length = 0.03;  // of a window along x
  std::size_t count = 0;
  double low_y = 0;
  double high_y = 0;
};

class ChuteDepth {
 public:
  static constexpr double kBinHeight = 0.0015;  // m
  static constexpr std::size_t kBins = 60;

  explicit ChuteDepth(const DepthWindows& windows);

  void accumulate(const dem::GrainTable& grains);

  // x_m, height_m (bin centre), streamwise_m_per_s, solid_fraction; empty bins are left out.
  core::Table table(std::string name) const;

  void save(core::State& state, const std::string& prefix) const;
  void load(const core::State& state, const std::string& prefix);

 private:
  DepthWindows windows_;
  double frames_ = 0;
  std::vector<double> count_;       // [window * kBins + bin]
  std::vector<double> volume_;      // m3, summed over frames
  std::vector<double> streamwise_;  // m/s, summed over grains
};

}  // namespace granary::measure
