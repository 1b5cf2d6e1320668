#include "worker/run/frame_schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace granary::run {
namespace {

// Times of the frames of a run with this step; `ask_every` steps lie between two looks at the
// clock, except where the schedule's own limit stops the engine.
std::vector<double> frame_times(const v1::Output& output, double end_time_s, double step_s,
                                int ask_every, int filling_steps = 0) {
  FrameSchedule schedule(output);
  std::vector<double> times;
  long step = -filling_steps;
  const auto time_s = [&] { return static_cast<double>(step) * step_s; };
  const auto finished = [&] { return time_s() >= end_time_s; };
  for (;;) {
    schedule.update(time_s(), end_time_s);
    if (schedule.due(time_s())) {
      times.push_back(time_s());
      schedule.taken(time_s());
    }
    if (finished()) break;
    const double limit_s = schedule.limit_s();
    for (int i = 0; i < ask_every && time_s() < limit_s && !finished(); ++i) ++step;
  }
  if (schedule.final_frame_due(time_s())) times.push_back(time_s());
  return times;
}

TEST(FrameSchedule, takes_about_a_hundred_frames_by_default_first_and_last_state_included) {
  const auto times = frame_times({}, 2.0, 1e-4, 7);
  EXPECT_EQ(times.size(), 101u);
  EXPECT_EQ(times.front(), 0);
  EXPECT_GE(times.back(), 2.0);
}

TEST(FrameSchedule, does_not_depend_on_chunks) {
  v1::Output output;
  output.set_frame_interval_s(0.0137);
  const auto fine = frame_times(output, 1.0, 3e-4, 1, 100);
  EXPECT_EQ(fine, frame_times(output, 1.0, 3e-4, 17, 100));
  EXPECT_EQ(fine, frame_times(output, 1.0, 3e-4, 100000, 100));
  for (std::size_t i = 0; i + 1 < fine.size(); ++i)
    EXPECT_LT(fine[i] - 0.0137 * static_cast<double>(i), 3e-4)
        << "later than the first step after its time";
}

TEST(FrameSchedule, covers_the_main_phase_unless_an_interval_is_named) {
  FrameSchedule schedule{v1::Output{}};
  schedule.update(0, 1.0);
  for (int i = 0; i <= 100; ++i) schedule.taken(0.01 * i);
  EXPECT_FALSE(schedule.due(1.5));
  EXPECT_FALSE(schedule.final_frame_due(1.5));
  EXPECT_EQ(schedule.limit_s(), INFINITY);
  v1::Output named;
  named.set_frame_interval_s(0.01);
  FrameSchedule all{named};
  all.update(0, 1.0);
  all.taken(1.0);
  EXPECT_TRUE(all.due(1.5));
  EXPECT_TRUE(all.final_frame_due(1.5));
}

TEST(FrameSchedule, takes_none_during_filling) {
  EXPECT_EQ(frame_times({}, 1.0, 1e-3, 10, 500).front(), 0);
}

TEST(FrameSchedule, zero_means_none) {
  v1::Output output;
  output.set_frame_interval_s(0);
  EXPECT_TRUE(frame_times(output, 1, 1e-3, 10).empty());
  v1::Output count;
  count.set_frames(0);
  EXPECT_TRUE(frame_times(count, 1, 1e-3, 10).empty());
}

TEST(FrameSchedule, follows_a_count) {
  v1::Output output;
  output.set_frames(4);
  const auto times = frame_times(output, 1, 1e-3, 10);
  ASSERT_EQ(times.size(), 5u);
  EXPECT_NEAR(times[1], 0.25, 1e-3);
}

TEST(FrameSchedule, steps_longer_than_the_interval_give_one_frame_a_step) {
  v1::Output output;
  output.set_frame_interval_s(0.01);
  EXPECT_EQ(frame_times(output, 1, 0.1, 1).size(), 11u);
}

TEST(FrameSchedule, goes_on_where_it_was_restored) {
  FrameSchedule first{v1::Output{}};
  first.update(0, 10);
  first.taken(0);
  FrameSchedule second{v1::Output{}};
  second.restore(first.state());
  second.update(0.05, 12);  // another end changes nothing any more
  EXPECT_EQ(second.state().next_index, 1u);
  EXPECT_DOUBLE_EQ(second.limit_s(), 0.1);
}

}  // namespace
}  // namespace granary::run
