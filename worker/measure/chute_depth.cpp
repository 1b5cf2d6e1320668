#include "worker/measure/chute_depth.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace granary::measure {

ChuteDepth::ChuteDepth(const DepthWindows& windows)
    : windows_(windows),
      count_(windows.count * kBins),
      volume_(windows.count * kBins),
      streamwise_(windows.count * kBins) {}

void ChuteDepth::accumulate(const dem::GrainTable& grains) {
  ++frames_;
  for (std::size_t k = 0; k < grains.size(); ++k) {
    const core::Vec3& p = grains.position[k];
    if (grains.carried[k] || p.y < windows_.low_y || p.y >= windows_.high_y || p.z < 0) continue;
    const double nearest = std::round((p.x - windows_.first_x) / windows_.spacing);
    if (nearest < 0 || nearest >= static_cast<double>(windows_.count)) continue;
    if (std::abs(p.x - windows_.first_x - nearest * windows_.spacing) > 0.5 * windows_.length) {
      continue;
    }
    const auto bin = static_cast<std::size_t>(p.z / kBinHeight);
    if (bin >= kBins) continue;
    const std::size_t slot = static_cast<std::size_t>(nearest) * kBins + bin;
    const double radius = grains.radius[k];
    count_[slot] += 1;
    volume_[slot] += 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
    streamwise_[slot] += grains.velocity[k].x;
  }
}

core::Table ChuteDepth::table(std::string name) const {
  const double bin_volume =
      windows_.length * (windows_.high_y - windows_.low_y) * kBinHeight * frames_;
  std::vector<double> x, height, streamwise, fraction;
  for (std::size_t slot = 0; slot < count_.size(); ++slot) {
    if (count_[slot] == 0) continue;
    x.push_back(windows_.first_x + static_cast<double>(slot / kBins) * windows_.spacing);
    height.push_back((static_cast<double>(slot % kBins) + 0.5) * kBinHeight);
    streamwise.push_back(streamwise_[slot] / count_[slot]);
    fraction.push_back(volume_[slot] / bin_volume);
  }
  return {std::move(name),
          {core::make_column<double>("x_m", "m", x),
           core::make_column<double>("height_m", "m", height),
           core::make_column<double>("streamwise_m_per_s", "m/s", streamwise),
           core::make_column<double>("solid_fraction", "1", fraction)}};
}

void ChuteDepth::save(core::State& state, const std::string& prefix) const {
  state.put_scalar(prefix + ".frames", "1", frames_);
  state.put(prefix + ".count", "1", count_);
  state.put(prefix + ".volume_m3", "m3", volume_);
  state.put(prefix + ".streamwise_sum_m_per_s", "m/s", streamwise_);
}

void ChuteDepth::load(const core::State& state, const std::string& prefix) {
  const auto count = state.get<double>(prefix + ".count");
  if (count.size() != count_.size()) throw std::runtime_error("state: profiles of another chute");
  frames_ = state.get_scalar<double>(prefix + ".frames");
  count_ = count;
  volume_ = state.get<double>(prefix + ".volume_m3");
  streamwise_ = state.get<double>(prefix + ".streamwise_sum_m_per_s");
}

}  // namespace granary::measure
