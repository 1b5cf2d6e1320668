// Our results beside those that the bucket-elevator paper prints. Rows come in groups, each of
// which runs the scenes it needs; bucket_elevator_scoreboard prints them all, bucket_elevator_test
// runs a reduced part of them.
#pragma once

#include <string>
#include <vector>

#include "tests/physics/papers/discharge_run.h"

namespace granary::tests {

enum class Verdict {
  agrees,              // within the tolerance that the row states
  agrees_spin_locked,  // only if the disks may not roll
  differs,
  reported  // the paper gives nothing to compare with: geometry or number not stated
};

struct Row {
  std::string claim;       // figure or table, and what it says
  std::string ours;        // with 95 % interval over fillings where it is a mean
  std::string paper;       // its simulation or formula; "-" = none
  std::string experiment;  // as the paper quotes it; "-" = none
  Verdict verdict = Verdict::reported;
  std::string note;  // tolerance, and what the paper does not state
};

struct Effort {
  int fillings = 3;  // seeds 1.. of every mean
  bool long_runs = true;
};

std::vector<Row> bead_rows(const Effort& effort);     // Table 2, Figs. 4 and 6
std::vector<Row> penalty_rows(const Effort& effort);  // Table 1, Figs. 9 and 12
std::vector<Row> flow_rows(const Effort& effort);     // Figs. 8, 10, 11, 13, 14; onset
std::vector<Row> design_rows(const Effort& effort);   // Tables 3 to 5, Fig. 18

// ---- what the groups share

scene::DischargePlan plan_of(const std::string& shipped_scene,
                             const std::vector<std::pair<std::string, std::string>>& settings);
// One run for each seed 1 .. fillings.
std::vector<DischargeRun> runs_of(const std::string& shipped_scene,
                                  const std::vector<std::pair<std::string, std::string>>& settings,
                                  int fillings);
// Rotation at which `percent` of the disks have left; NaN if they stay.
double angle_of_percent_left(const DischargeRun& run, double percent);

template <typename Function>
Sample over(const std::vector<DischargeRun>& runs, Function measure) {
  std::vector<double> values;
  for (const DischargeRun& run : runs) values.push_back(measure(run));
  return summarize(values);
}
Sample value_over(const std::vector<DischargeRun>& runs, const std::string& name);

std::string text(double value, int digits);
std::string text(const Sample& sample, int digits);  // "1.94 +- 0.01"

Verdict judge(bool holds);

}  // namespace granary::tests
