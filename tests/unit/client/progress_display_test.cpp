#include "client/render/progress_display.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/fake_jobs_service.h"

namespace granary::render {
namespace {

using test::progress_event;
using test::state_event;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(ProgressDisplay, writes_plain_lines_at_most_one_a_second_without_a_terminal) {
  std::ostringstream out;
  ProgressDisplay display(out, {.is_terminal = false}, "jobs/1");
  display.show(state_event(1, v1::RUNNING), 0);
  for (int tick = 0; tick < 40; ++tick)
    display.show(progress_event(2 + tick, tick / 100.0), tick * 0.1);  // four seconds
  display.show(state_event(50, v1::COMPLETE), 4);
  display.close();
  const std::string text = out.str();
  EXPECT_EQ(count(text, "rotation"), 4u) << text;
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_EQ(text.rfind("jobs/1: running\n", 0), 0u);
  EXPECT_NE(text.find("jobs/1: [####################] 100 %  complete\n"), std::string::npos);
}

TEST(ProgressDisplay, redraws_in_place_on_a_terminal) {
  std::ostringstream out;
  ProgressDisplay display(out, {.is_terminal = true, .ansi = true, .width = 30}, "jobs/1");
  v1::JobEvent event = progress_event(1, 0.5);
  event.mutable_progress()->set_particles(700);  // a second line at this width
  display.show(event, 0);
  out.str("");
  display.show(event, 1);
  EXPECT_EQ(out.str().rfind("\r\x1b[1A\x1b[J[###", 0), 0u) << out.str();
  out.str("");
  display.close();
  EXPECT_EQ(out.str(), "\n");
}

TEST(ProgressDisplay, uses_no_escape_sequence_under_no_color) {
  std::ostringstream out;
  ProgressDisplay display(out, {.is_terminal = true, .ansi = false, .width = 40}, "jobs/1");
  display.show(progress_event(1, 0.5), 0);
  display.show(progress_event(2, 0.6), 1);
  display.show(state_event(3, v1::COMPLETE), 2);
  display.close();
  EXPECT_EQ(out.str().find('\x1b'), std::string::npos);
  EXPECT_EQ(count(out.str(), "\r"), 4u);  // two drawings, one erasure of two
}

TEST(ProgressDisplay, tells_why_a_job_ended_badly) {
  std::ostringstream out;
  ProgressDisplay display(out, {.is_terminal = false}, "jobs/1");
  v1::JobEvent event = state_event(1, v1::UNSTABLE);
  event.set_message("overlap 1.2 R at t = 0.3 s\x1b[2J");
  display.show(event, 0);
  EXPECT_EQ(out.str(), "jobs/1: unstable: overlap 1.2 R at t = 0.3 s [2J\n");
}

}  // namespace
}  // namespace granary::render
