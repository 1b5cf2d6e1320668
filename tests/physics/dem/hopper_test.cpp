// Claim: a hopper feeds the chute: it fills behind its gate, runs out of its slot
//   at a steady rate that a wider or higher slot raises as slots do, and loses no grain.
// Method: the shipped chute_hopper: a bin of 50 x 30 x 50 mm with 3 mm beads behind a chute of 30
//   degrees, 0.1 m long; slots of 15 and 22 mm; 0.252 s, whose last step is a frame.
// Reference: mass is conserved; flow through a slot of height h: between h (a plug that leaves at a
//   fixed speed) and (h - k d)^(3/2), k = 1.4 (Beverloo, for slots: Q ~ (W - k d)(h - k d)^(3/2)).
// Tolerance: grains are counted; the two halves of the steady time agree within the sum of their 95
// %
//   intervals, as two estimates of one mean do in more than 99 % of all cases; the ratio of flows
//   lies between both laws, widened by the intervals.
// Seconds: 9
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/shipped_scenes.h"
#include "worker/core/blocking.h"
#include "worker/scene/chute.h"

namespace granary::tests {
namespace {

constexpr std::uint64_t kNoLimit = std::uint64_t{1} << 40;
constexpr double kDiameter = 0.003;

v1::Scene hopper_scene(const std::vector<FieldSetting>& more = {}) {
  std::vector<FieldSetting> set = {
      {"chute.duration_s", "0.252"},
      {"chute.sample_start_s", "0.08"},
      {"chute.sample_interval_s", "0.004"},
  };
  set.insert(set.end(), more.begin(), more.end());
  return shipped_scene("chute_hopper", set);
}

double grain_mass() {
  return 2550 * M_PI / 6 * std::pow(kDiameter, 3);
}

std::vector<double> column(const core::Observation& seen, const std::string& name) {
  for (const core::Table& table : seen.series) {
    if (table.name != "hopper") continue;
    for (const core::Column& c : table.columns) {
      if (c.name != name) continue;
      const std::span<const double> rows = c.as<double>();
      return {rows.begin(), rows.end()};
    }
  }
  ADD_FAILURE() << "no column " << name;
  return {};
}

core::ObservedValue value(const core::Observation& seen, const std::string& name) {
  for (const core::ObservedValue& v : seen.values) {
    if (v.name == name) return v;
  }
  ADD_FAILURE() << "no value " << name;
  return {};
}

struct Discharged {
  std::unique_ptr<core::Simulation> simulation;
  std::size_t filled = 0;  // grains when the gate opens
  core::Observation seen;
  double flow = 0, error = 0;  // kg/s
};

Discharged discharge(const std::vector<FieldSetting>& set) {
  Discharged run;
  run.simulation = scene::make_chute(hopper_scene(set));
  while (run.simulation->progress().phase == "filling") run.simulation->advance(0, 1000);
  run.filled = run.simulation->progress().particles;
  EXPECT_EQ(run.simulation->advance(1, kNoLimit).status, core::AdvanceStatus::finished);
  run.seen = run.simulation->observe();
  const core::ObservedValue flow = value(run.seen, "hopper_flow_kg_per_s");
  EXPECT_TRUE(flow.value && flow.error) << flow.error_basis;
  run.flow = flow.value.value_or(0);
  run.error = flow.error.value_or(0);
  return run;
}

const Discharged& as_shipped() {
  static const Discharged run = discharge({});
  return run;
}

TEST(Hopper, starts_behind_its_gate_runs_steadily_and_loses_no_grain) {
  const auto& [simulation, filled, seen, whole_flow, whole_error] = as_shipped();
  EXPECT_GT(filled, 3000U);
  const std::vector<double> mass = column(seen, "hopper_mass_kg");
  const std::vector<double> flow = column(seen, "hopper_flow_kg_per_s");
  const std::vector<double> time = column(seen, "time_s");
  EXPECT_NEAR(mass.front(), static_cast<double>(filled) * grain_mass(), 1e-9);  // none in the slot
  EXPECT_GT(flow[10], 0.3 * whole_flow);  // 0.04 s after it opened
  EXPECT_LT(whole_error, 0.1 * whole_flow);
  const auto first =
      static_cast<std::size_t>(std::lower_bound(time.begin(), time.end(), 0.08) - time.begin());
  const std::size_t half = (time.size() - first) / 2;
  const auto part = [&](std::size_t begin) {
    return core::blocked_mean(std::span(flow).subspan(begin, half));
  };
  const core::MeanWithError early = part(first), late = part(first + half);
  ASSERT_TRUE(early.half_width && late.half_width);
  EXPECT_NEAR(early.mean, late.mean, *early.half_width + *late.half_width);
  // Every grain is in the hopper, in the chute or has left.
  std::size_t left = 0;
  for (const core::Table& table : seen.fields) {
    if (table.name == "leaving_grains") left = table.columns[0].rows;
  }
  EXPECT_GT(left, 200U);
  const double in_hopper = mass.back() / grain_mass();
  std::size_t in_chute = 0;
  for (const core::ColumnView& view : simulation->frame()) {
    if (view.name != "position_m") continue;
    const auto* x = static_cast<const double*>(view.data);
    for (std::size_t k = 0; k < 3 * view.rows; k += 3) in_chute += x[k] >= 0 && x[k] <= 0.1 ? 1 : 0;
  }
  EXPECT_EQ(static_cast<std::size_t>(std::lround(in_hopper)) + in_chute + left, filled);
}

TEST(Hopper, higher_slot_lets_more_through_as_slots_do) {
  const Discharged& low = as_shipped();
  const Discharged high = discharge({{"chute.inlet.hopper_opening_m", "0.022"}});
  const double ratio = high.flow / low.flow;
  const double spread = ratio * (high.error / high.flow + low.error / low.flow);
  const double plug = 22.0 / 15, beverloo = std::pow((22 - 1.4 * 3) / (15 - 1.4 * 3), 1.5);
  EXPECT_GT(ratio, plug - spread);
  EXPECT_LT(ratio, beverloo + spread);
}

TEST(Hopper, narrow_slot_lets_less_through) {
  const Discharged& whole = as_shipped();
  const Discharged narrow = discharge({{"chute.inlet.hopper_opening_width_m", "0.018"}});
  const double ratio = narrow.flow / whole.flow;
  const double spread = ratio * (narrow.error / narrow.flow + whole.error / whole.flow);
  EXPECT_LT(ratio, 18.0 / 30 + spread);  // a plug
  EXPECT_GT(ratio, 0);
}

TEST(Hopper, restored_run_goes_on_bitwise) {
  const std::vector<FieldSetting> brief = {{"chute.duration_s", "0.06"},
                                           {"chute.sample_start_s", "0.02"}};
  const auto hash_of = [](const core::Simulation& simulation) {
    return core::hash_columns(simulation.physical_state());
  };
  const auto whole = scene::make_chute(hopper_scene(brief));
  whole->advance(0.031, kNoLimit);
  const core::State state = whole->snapshot();
  whole->advance(1, kNoLimit);
  const auto resumed = scene::make_chute(hopper_scene(brief));
  resumed->restore(state);
  EXPECT_EQ(resumed->advance(1, kNoLimit).status, core::AdvanceStatus::finished);
  EXPECT_EQ(hash_of(*whole), hash_of(*resumed));
  EXPECT_EQ(column(whole->observe(), "hopper_mass_kg"),
            column(resumed->observe(), "hopper_mass_kg"));
}

}  // namespace
}  // namespace granary::tests
