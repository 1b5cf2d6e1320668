#include "worker/measure/hopper_record.h"

#include <algorithm>
#include <cstdio>

#include "worker/core/blocking.h"
#include "worker/measure/frame_time.h"

namespace granary::measure {

void HopperRecord::sample(double time, const dem::GrainTable& grains) {
  double mass = 0;
  for (std::size_t k = 0; k < grains.size(); ++k) {
    if (grains.carried[k] == 0 && grains.position[k].x < 0) mass += grains.mass[k];
  }
  times_.push_back(time);
  mass_.push_back(mass);
}

std::vector<double> HopperRecord::flows() const {
  std::vector<double> flow(times_.size(), 0);
  for (std::size_t k = 1; k < times_.size(); ++k) {
    flow[k] = (mass_[k - 1] - mass_[k]) / (times_[k] - times_[k - 1]);
  }
  return flow;
}

// First frame that is too empty.
std::size_t HopperRecord::steady_end() const {
  const double least = mass_.empty() ? 0 : kLeastFill * mass_.front();
  const auto low = std::find_if(mass_.begin(), mass_.end(), [&](double m) { return m < least; });
  return static_cast<std::size_t>(low - mass_.begin());
}

void HopperRecord::add_to(core::Observation& observation) const {
  core::ObservedValue value{"hopper_flow_kg_per_s", "kg/s", std::nullopt, std::nullopt,
                            "no frame in the sampling time with a hopper that is full enough"};
  const std::vector<double> flow = flows();
  // The flow of a frame is that since the frame before: the one at sample_start is too early.
  const auto sampled = std::upper_bound(times_.begin(), times_.end(), latest_of(sample_start_));
  const auto first = static_cast<std::size_t>(sampled - times_.begin());
  const std::size_t end = steady_end();
  if (first < end) {
    const std::vector<double> rows(flow.begin() + static_cast<std::ptrdiff_t>(first),
                                   flow.begin() + static_cast<std::ptrdiff_t>(end));
    const core::MeanWithError mean = core::blocked_mean(rows);
    value.value = mean.mean;
    value.error = mean.half_width;
    value.error_basis = mean.half_width ? "blocking over " + std::to_string(rows.size()) + " frames"
                                        : "too few frames for an interval";
  }
  observation.values.push_back(value);
  if (end < times_.size()) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "the hopper held less than %.0f %% of its fill from %.4g s on: "
                  "hopper_flow_kg_per_s leaves that out",
                  100 * kLeastFill, times_[end]);
    observation.warnings.push_back(text);
  }
  observation.series.push_back({"hopper",
                                {core::make_column<double>("time_s", "s", times_),
                                 core::make_column<double>("hopper_mass_kg", "kg", mass_),
                                 core::make_column<double>("hopper_flow_kg_per_s", "kg/s", flow)}});
}

void HopperRecord::save(core::State& state) const {
  state.put("hopper.time_s", "s", times_);
  state.put("hopper.mass_kg", "kg", mass_);
}

void HopperRecord::load(const core::State& state) {
  times_ = state.get<double>("hopper.time_s");
  mass_ = state.get<double>("hopper.mass_kg");
}

}  // namespace granary::measure
