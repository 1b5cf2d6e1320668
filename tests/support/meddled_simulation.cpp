#include "tests/support/meddled_simulation.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace granary::testing {
namespace {

// Where the first row of a column of velocities keeps the component along y: "dem.motion" rows are
// position, inverse mass, velocity, step.
std::optional<std::size_t> place_of_vy(const std::string& column) {
  if (column == "disk_motion" || column == "dem.velocity_half_m_per_s") return 1;
  if (column == "dem.motion") return 5;
  return {};
}

void edit_velocity(core::State& state, const std::function<double(double)>& edit) {
  for (core::Column& column : state.columns) {
    const auto place = place_of_vy(column.name);
    if (!place) continue;
    if (column.rows == 0) return;
    double value = 0;
    std::byte* bytes = column.bytes.data() + *place * sizeof(double);
    std::memcpy(&value, bytes, sizeof value);
    value = edit(value);
    std::memcpy(bytes, &value, sizeof value);
    return;
  }
  throw std::logic_error("no engine whose velocities are known here");
}

}  // namespace

MeddledSimulation::MeddledSimulation(std::unique_ptr<core::Simulation> inner, Meddling meddling,
                                     std::shared_ptr<std::uint64_t> done)
    : inner_(std::move(inner)), meddling_(std::move(meddling)), done_(std::move(done)) {}

core::AdvanceOutcome MeddledSimulation::advance(double until_time_s, std::uint64_t max_steps) {
  const std::uint64_t now = inner_->progress().steps;
  if (*done_ < meddling_.count && now >= next_step()) {
    core::State state = inner_->snapshot();
    meddling_.change(state);
    inner_->restore(state);
    ++*done_;
  }
  const std::uint64_t until = *done_ < meddling_.count ? next_step() : max_steps + now;
  return inner_->advance(until_time_s, std::min(max_steps, std::max(until, now + 1) - now));
}

std::function<void(core::State&)> velocity_becomes_nan() {
  return [](core::State& state) {
    edit_velocity(state, [](double) { return std::numeric_limits<double>::quiet_NaN(); });
  };
}

std::function<void(core::State&)> velocity_jumps_by(double along_y_m_per_s) {
  return [along_y_m_per_s](core::State& state) {
    edit_velocity(state, [&](double velocity) { return velocity + along_y_m_per_s; });
  };
}

}  // namespace granary::testing
