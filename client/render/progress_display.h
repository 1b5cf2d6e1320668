// Shows a job's events as they come. On a terminal a block of lines is redrawn in place; elsewhere
// a plain line per state change and at most one a second for progress. Time is an argument.
#pragma once

#include <cstddef>
#include <ostream>
#include <string>

#include "granary/v1/job.pb.h"

namespace granary::render {

struct Terminal {
  bool is_terminal = false;
  bool ansi = false;       // escape sequences allowed: a terminal and no NO_COLOR
  std::size_t width = 80;  // columns
};

// What standard error is now.
Terminal terminal_of_stderr();

class ProgressDisplay {
 public:
  ProgressDisplay(std::ostream& out, Terminal terminal, std::string job);

  void show(const v1::JobEvent& event, double now_s);
  // Leaves what is drawn and moves below it, so that other text can follow.
  void close();

 private:
  void show_state(v1::JobState state, const std::string& message);
  void show_progress(const v1::Progress& progress, double now_s);
  void draw(const v1::Progress& progress);
  void erase();

  std::ostream& out_;
  Terminal terminal_;
  std::string job_;
  double shown_at_s_ = -1e9;
  std::size_t lines_drawn_ = 0;
};

}  // namespace granary::render
