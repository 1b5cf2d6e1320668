// A discharge scene run to its end angle, with what the papers' figures show of it: who left when,
// when the bed began to slip, when it let go of the outer wall.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "worker/scene/discharge_plan.h"

namespace granary::tests {

struct DiskHistory {
  double left_deg = 0;  // rotation at which it left the bucket for good; NaN = stayed
  std::uint32_t stratum = 0;
  double distance_to_outer_wall = 0;  // m, at the start
};

struct DischargeRun {
  std::map<std::string, double> values;  // by their names in the result; missing = not known
  std::vector<double> remaining;         // % at whole degrees
  std::vector<DiskHistory> disks;
  double slip_deg = 0;      // the disks' mean path inside the bucket exceeds their mean radius
  double cg_moves_deg = 0;  // the bed's centroid has moved by a diameter in the bucket
  double off_outer_wall_deg = 0;  // from here on less than 1 % of the disks press the outer wall
  double filled_mass = 0;         // kg
  double energy_by_penalty = 0;   // J put in by raising the penalty under load
  double final_stiffness = 0;     // N/m
  std::uint64_t steps = 0, iterations = 0, unconverged = 0;  // of the rotation
  std::vector<std::string> warnings;
  bool finished = false;
};

// Until the end angle; the landing is not run.
DischargeRun run_discharge(const scene::DischargePlan& plan);

// Mean rotation at which the disks of a stratum left (0 = lowest).
double mean_exit_of_stratum(const DischargeRun& run, std::uint32_t stratum);
// The same of the disks within `share` of the bed's largest distance to the outer wall, and of the
// others.
struct ExitByPlace {
  double near_outer = 0, far_from_outer = 0;
};
ExitByPlace mean_exit_by_place(const DischargeRun& run, double share);

struct Sample {
  double mean = 0;
  double error = 0;  // half-width of the 95 % interval of the mean
};
// Student's t; error NaN with fewer than two values.
Sample summarize(const std::vector<double>& values);

}  // namespace granary::tests
