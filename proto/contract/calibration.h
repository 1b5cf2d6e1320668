// What runs on this host have cost compared with the shipped price list: one ratio per engine,
// learnt from finished runs. A small text file, $GRANARY_CALIBRATION, else $XDG_CACHE_HOME (or
// ~/.cache) /granary/calibration: a line "engine runs mean-of-log variance-of-log" each. Losing it
// loses nothing but the narrower interval.
#pragma once

#include <map>
#include <string>

namespace granary {

struct SpeedRatio {
  double runs = 0;          // that it rests on; old ones fade
  double log_mean = 0;      // of measured / predicted CPU seconds
  double log_variance = 0;  // between runs
};

class Calibration {
 public:
  // An absent or unreadable file is an empty calibration.
  static Calibration load(const std::string& path = default_path());
  static std::string default_path();  // "" when the environment names no home

  const SpeedRatio* find(const std::string& engine) const;
  // Half-width of the 95 % interval of log(measured / predicted) for the next run.
  double log_half_width(const std::string& engine) const;
  void note(const std::string& engine, double measured_over_predicted);
  // Replaces the file at once; false when that is not possible, which nobody need mind.
  bool save(const std::string& path = default_path()) const;

 private:
  std::map<std::string, SpeedRatio> ratios_;
};

}  // namespace granary
