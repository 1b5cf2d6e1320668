#include "client/render/progress_line.h"

#include <gtest/gtest.h>

#include <cmath>

namespace granary::render {
namespace {

v1::Progress rotation() {
  v1::Progress progress;
  progress.set_fraction(0.476);
  progress.set_phase("rotation");
  progress.set_time_s(0.8123);
  progress.set_end_time_s(1.72);
  progress.set_eta_s(12.3);
  progress.set_particles(700);
  progress.set_contacts(1650);
  progress.set_steps(4000);
  progress.set_ns_per_particle_step(12.34);
  progress.set_ledger_remainder_ratio(1.2e-6);
  (*progress.mutable_current_values())["f3_percent"] = 12.5;
  (*progress.mutable_current_values())["f1_m"] = 1.92;
  return progress;
}

TEST(ProgressLine, says_everything_a_watcher_wants) {
  EXPECT_EQ(progress_line(rotation()),
            "[#########...........]  47 %  rotation  t 0.812/1.72 s  ETA 0:12  700 particles  "
            "1650 contacts  12.3 ns/particle-step  f1_m 1.92  f3_percent 12.5  ledger 1.2e-06");
}

TEST(ProgressLine, leaves_out_what_the_engine_did_not_say) {
  v1::Progress progress;
  progress.set_fraction(0.5);
  EXPECT_EQ(progress_line(progress), "[##########..........]  50 %");
}

TEST(ProgressLine, never_shows_100_percent_before_the_end_nor_beyond) {
  v1::Progress progress;
  progress.set_fraction(0.9999);
  EXPECT_EQ(progress_line(progress), "[###################.]  99 %");
  progress.set_fraction(1);
  EXPECT_EQ(progress_line(progress), "[####################] 100 %");
  progress.set_fraction(7);
  EXPECT_EQ(progress_line(progress), "[####################] 100 %");
  progress.set_fraction(-1);
  EXPECT_EQ(progress_line(progress), "[....................]   0 %");
}

TEST(ProgressLine, hides_numbers_that_are_none) {
  v1::Progress progress = rotation();
  progress.set_eta_s(NAN);
  (*progress.mutable_current_values())["f1_m"] = NAN;
  progress.set_ledger_remainder_ratio(INFINITY);
  const std::string line = progress_line(progress);
  for (const char* absent : {"nan", "inf", "ETA", "f1_m", "ledger"})
    EXPECT_EQ(line.find(absent), std::string::npos) << line;
}

TEST(ProgressLine, shows_the_criteria_alone_once_they_are_there) {
  v1::Progress progress;
  for (const char* name : {"a50_deg", "b", "c", "d", "e"})
    (*progress.mutable_current_values())[name] = 1;
  EXPECT_NE(progress_line(progress).find("a50_deg 1  b 1  c 1  d 1"), std::string::npos);
  EXPECT_EQ(progress_line(progress).find("e 1"), std::string::npos);
  (*progress.mutable_current_values())["f4_m"] = 0.5;
  EXPECT_EQ(progress_line(progress), "[....................]   0 %  f4_m 0.5");
}

TEST(ProgressLine, leaves_out_an_end_that_is_behind) {
  v1::Progress progress = rotation();
  progress.set_time_s(1.9);  // still landing after the end of the rotation
  EXPECT_NE(progress_line(progress).find("  t 1.9 s  "), std::string::npos);
}

TEST(ProgressLine, counts_replicates_from_one) {
  v1::Progress progress;
  progress.set_replicates(4);
  progress.set_replicate(1);
  EXPECT_NE(progress_line(progress).find("replicate 2/4"), std::string::npos);
}

TEST(ProgressLines, break_between_segments_and_never_exceed_the_width) {
  for (std::size_t width : {20, 40, 80, 200}) {
    std::string joined;
    for (const std::string& line : progress_lines(rotation(), width)) {
      EXPECT_LE(line.size(), width);
      joined += (joined.empty() ? "" : "  ") + line;
    }
    if (width >= 40) {
      EXPECT_EQ(joined, progress_line(rotation()));
    }
  }
}

TEST(ClockText, grows_with_the_duration) {
  EXPECT_EQ(clock_text(0), "0:00");
  EXPECT_EQ(clock_text(12.4), "0:12");
  EXPECT_EQ(clock_text(59.9), "1:00");
  EXPECT_EQ(clock_text(3725), "1:02:05");
  EXPECT_EQ(clock_text(90000), "1d 1:00:00");
}

}  // namespace
}  // namespace granary::render
