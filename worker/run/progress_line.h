// Progress on a terminal: one line that is written over; elsewhere a plain line now and then.
#pragma once

#include <string>

#include "granary/v1/result.pb.h"

namespace granary::run {

std::string progress_text(const v1::Progress& progress);
std::string duration_text(double seconds);  // "4.2 s", "3 min 20 s", "2 h 05 min"

class ProgressLine {
 public:
  explicit ProgressLine(bool enabled);  // asks the terminal itself
  void show(const v1::Progress& progress);
  void log(const std::string& line);  // between progress, on its own line
  void end();

 private:
  bool enabled_;
  bool terminal_;
  std::size_t width_ = 0;     // of the text on the terminal now
  double next_fraction_ = 0;  // plain lines: one per 10 %
};

}  // namespace granary::run
