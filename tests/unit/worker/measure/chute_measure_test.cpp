#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "worker/measure/chute_depth.h"
#include "worker/measure/chute_observer.h"
#include "worker/measure/chute_segregation.h"
#include "worker/measure/chute_surface.h"

namespace granary::measure {
namespace {

void add(dem::GrainTable& table, const core::Vec3& position, const core::Vec3& velocity = {},
         std::uint8_t grain_class = 0, bool carried = false) {
  table.id.push_back(static_cast<std::int64_t>(table.size()));
  table.position.push_back(position);
  table.velocity.push_back(velocity);
  table.spin.push_back({});
  table.radius.push_back(0.0015);
  table.mass.push_back(3.6e-5);
  table.grain_class.push_back(grain_class);
  table.carried.push_back(carried ? 1 : 0);
}

double at(const core::Table& table, std::size_t column, std::size_t row) {
  return table.columns.at(column).as<double>()[row];
}

// All in the cell x 0..6 mm, y 0..5 mm.
dem::GrainTable stack_of(std::size_t count) {
  dem::GrainTable table;
  for (std::size_t k = 0; k < count; ++k) {
    const double z = 0.0015 + 0.003 * static_cast<double>(k);
    add(table, {0.003, 0.0025, z}, {static_cast<double>(k), 10 * static_cast<double>(k), 0});
  }
  return table;
}

TEST(ChuteSurface, velocity_is_the_mean_of_the_topmost_six) {
  ChuteSurface surface(0.06, 0.05);
  surface.look(stack_of(9));
  surface.accumulate();
  const core::Table table = surface.velocity_table();
  ASSERT_EQ(table.columns[0].rows, 1U);
  EXPECT_DOUBLE_EQ(at(table, 0, 0), 0.003);
  EXPECT_DOUBLE_EQ(at(table, 1, 0), 0.0025);
  EXPECT_DOUBLE_EQ(at(table, 2, 0), (3 + 4 + 5 + 6 + 7 + 8) / 6.0);
  EXPECT_DOUBLE_EQ(at(table, 3, 0), 10 * (3 + 4 + 5 + 6 + 7 + 8) / 6.0);
}

TEST(ChuteSurface, velocity_needs_three_grains_and_height_needs_one) {
  ChuteSurface surface(0.06, 0.05);
  surface.look(stack_of(2));
  surface.accumulate();
  EXPECT_EQ(surface.velocity_table().columns[0].rows, 0U);
  EXPECT_DOUBLE_EQ(at(surface.height_table(), 2, 0), 0.006);
}

TEST(ChuteSurface, height_counts_empty_frames_and_velocity_does_not) {
  ChuteSurface surface(0.06, 0.05);
  surface.look(stack_of(3));
  surface.accumulate();
  surface.look({});
  surface.accumulate();
  EXPECT_DOUBLE_EQ(at(surface.height_table(), 2, 0), 0.009 / 2);
  EXPECT_DOUBLE_EQ(at(surface.velocity_table(), 2, 0), 1);
}

TEST(ChuteSurface, sensor_is_the_unweighted_mean_of_25_cells) {
  ChuteSurface surface(0.9, 0.08);
  dem::GrainTable table;
  add(table, {0.2 + 0.001, 0.0175, 0.0285});  // top at 30 mm, one cell of 25
  surface.look(table);
  EXPECT_NEAR(surface.sensor_height(0.2, 0.0175), 0.03 / 25, 1e-12);
}

TEST(ChuteSurface, grains_outside_and_carried_grains_are_not_seen) {
  ChuteSurface surface(0.06, 0.05);
  dem::GrainTable table;
  add(table, {-0.001, 0.01, 0.01});
  add(table, {0.061, 0.01, 0.01});
  add(table, {0.003, 0.0025, 0.01}, {}, 0, true);
  surface.look(table);
  surface.accumulate();
  const core::Table heights = surface.height_table();
  for (const double height : heights.columns[2].as<double>()) EXPECT_EQ(height, 0);
}

TEST(ChuteDepth, solid_fraction_is_grain_volume_over_bin_volume) {
  ChuteDepth depth({0.2, 0.2, 0.03, 1, 0, 0.08});
  dem::GrainTable table;
  for (int k = 0; k < 10; ++k) add(table, {0.19 + 0.002 * k, 0.04, 0.001}, {2, 0, 0});
  add(table, {0.25, 0.04, 0.001}, {9, 0, 0});  // outside the window
  depth.accumulate(table);
  const core::Table profile = depth.table("depth_profile");
  ASSERT_EQ(profile.columns[0].rows, 1U);
  const double grain = 4.0 / 3.0 * std::numbers::pi * 0.0015 * 0.0015 * 0.0015;
  EXPECT_NEAR(at(profile, 3, 0), 10 * grain / (0.03 * 0.08 * 0.0015), 1e-12);
  EXPECT_DOUBLE_EQ(at(profile, 2, 0), 2);
  EXPECT_DOUBLE_EQ(at(profile, 1, 0), 0.00075);
}

TEST(ChuteSegregation, is_one_when_separated_and_zero_when_mixed) {
  ChuteSegregation separated(0.09, 0.08);
  ChuteSegregation mixed(0.09, 0.08);
  for (int frame = 0; frame < 20; ++frame) {
    dem::GrainTable apart;
    dem::GrainTable together;
    for (int k = 0; k < 16; ++k) {
      const double y = 0.0025 + 0.005 * k;
      add(apart, {0.045, y, 0.01}, {}, k < 8 ? 0 : 1);
      add(together, {0.045, y, 0.01}, {}, 0);
      add(together, {0.045, y, 0.01}, {}, 1);
    }
    separated.accumulate(apart);
    mixed.accumulate(together);
  }
  EXPECT_NEAR(*separated.values()[1].value, 1, 1e-12);
  EXPECT_NEAR(*mixed.values()[1].value, 0, 1e-12);
  EXPECT_NEAR(*separated.values()[1].error, 0, 1e-7);
}

TEST(ChuteObserver, exit_values_come_from_leaving_grains_of_the_sampling_time) {
  ChuteObserver observer({0.9, 0.08}, 1.0, false);
  for (int frame = 0; frame <= 40; ++frame) {
    const double time = 0.05 * frame;
    std::vector<dem::Leaver> leavers;
    if (frame > 0) {
      const double speed = time <= 1.0 ? 5.0 : 2.0;
      leavers.assign(3, {time - 0.01, 0, {0.9, 0, 0}, {speed, 0, 0}, 0.003, 0.02});
    }
    observer.sample(time, stack_of(4), leavers);
  }
  const core::Observation seen = observer.observe();
  EXPECT_EQ(seen.values[0].name, "particle_count");
  EXPECT_DOUBLE_EQ(*seen.values[0].value, 4);
  EXPECT_EQ(seen.values[1].name, "mass_flow_kg_per_s");
  EXPECT_NEAR(*seen.values[1].value, 3 * 0.02 / 0.05, 1e-9);
  EXPECT_NEAR(*seen.values[1].error, 0, 1e-9);
  EXPECT_EQ(seen.values[2].name, "exit_speed_m_per_s");
  EXPECT_DOUBLE_EQ(*seen.values[2].value, 2);
}

TEST(ChuteObserver, unknown_values_say_why) {
  ChuteObserver observer({0.3, 0.08}, 1.0, false);
  for (const core::ObservedValue& value : observer.observe().values) {
    EXPECT_FALSE(value.value.has_value()) << value.name;
    EXPECT_FALSE(value.error_basis.empty()) << value.name;
  }
}

TEST(ChuteObserver, restored_observer_goes_on_as_if_never_stopped) {
  ChuteObserver whole({0.3, 0.08}, 0.1, true);
  ChuteObserver first({0.3, 0.08}, 0.1, true);
  ChuteObserver second({0.3, 0.08}, 0.1, true);
  const std::vector<dem::Leaver> leavers(2, {0.1, 5, {0.3, 0, 0}, {1, 0, 0}, 0.003, 3.6e-5});
  const auto go = [&](ChuteObserver& observer, int from, int to) {
    for (int k = from; k < to; ++k) observer.sample(0.02 * k, stack_of(3 + k % 3), leavers);
  };
  go(whole, 0, 30);
  go(first, 0, 13);
  core::State state;
  first.save(state);
  second.load(state);
  go(second, 13, 30);
  const core::Observation expected = whole.observe();
  const core::Observation actual = second.observe();
  for (std::size_t k = 0; k < expected.values.size(); ++k) {
    EXPECT_EQ(expected.values[k].value, actual.values[k].value) << expected.values[k].name;
    EXPECT_EQ(expected.values[k].error, actual.values[k].error) << expected.values[k].name;
  }
  for (std::size_t k = 0; k < expected.fields.size(); ++k) {
    for (std::size_t c = 0; c < expected.fields[k].columns.size(); ++c) {
      EXPECT_EQ(expected.fields[k].columns[c].bytes, actual.fields[k].columns[c].bytes);
    }
  }
}

// The step 10 x 1e-6 is one ulp short of 1e-5, and its multiples of what they stand for.
TEST(ChuteObserver, frame_due_at_the_start_of_sampling_counts_whatever_the_rounding) {
  for (const double step : {1e-5, 10 * 1e-6, 8e-6}) {
    ChuteObserver observer({0.3, 0.08}, 0.2, false);
    for (int frame = 0; frame < 3; ++frame) {
      const double steps = std::round((0.19 + 0.01 * frame) / step);
      observer.sample(steps * step, stack_of(frame == 1 ? 4 : 2), {});
    }
    const core::Observation seen = observer.observe();
    ASSERT_EQ(seen.values[0].name, "particle_count");
    EXPECT_EQ(seen.values[0].value, 3) << step;  // of the last two frames
  }
}

}  // namespace
}  // namespace granary::measure
