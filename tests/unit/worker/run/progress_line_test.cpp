#include "worker/run/progress_line.h"

#include <gtest/gtest.h>

namespace granary::run {
namespace {

TEST(ProgressLine, tells_how_far_how_fast_and_how_long_still) {
  v1::Progress progress;
  progress.set_fraction(0.5);
  progress.set_phase("rotation");
  progress.set_time_s(1.5);
  progress.set_end_time_s(3);
  progress.set_particles(700);
  progress.set_contacts(1200);
  progress.set_ns_per_particle_step(42);
  progress.set_eta_s(200);
  EXPECT_EQ(
      progress_text(progress),
      "[############............]  50 %  rotation t = 1.5 of 3 s  700 particles, 1200 contacts"
      "  42 ns/particle-step  3 min 20 s left");
}

TEST(ProgressLine, stays_in_its_bar_for_any_fraction) {
  v1::Progress progress;
  for (const double fraction : {-1.0, 0.0, 1.0, 7.0}) {
    progress.set_fraction(fraction);
    EXPECT_EQ(progress_text(progress).find(']'), 25u);
  }
}

TEST(ProgressLine, writes_durations_as_people_do) {
  EXPECT_EQ(duration_text(4.24), "4.2 s");
  EXPECT_EQ(duration_text(200), "3 min 20 s");
  EXPECT_EQ(duration_text(7500), "2 h 05 min");
}

}  // namespace
}  // namespace granary::run
