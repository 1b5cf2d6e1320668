// Runs a chute scene in this process and reads means off its observation, by the definitions of
// PHYSICS section H. Shared by the base-case test and the program that scores the chute paper.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "granary/v1/scene.pb.h"
#include "worker/core/simulation.h"

namespace granary::tests {

struct Mean {
  double value = 0;
  double error = 0;  // half-width of the 95 % interval, 0 where there is none
};

class ChuteMeans {
 public:
  // Throws std::runtime_error when the scene is refused or the run rejected.
  static ChuteMeans of_run(const v1::Scene& resolved);

  Mean value(const std::string& name) const;
  // Surface velocity over x +- 15 mm and the rows of cells with low_y <= y < high_y [m/s].
  double surface_velocity(double x, double low_y = 0, double high_y = 1) const;
  // Across, over the same cells; > 0 towards y = width [m/s].
  double spanwise_velocity(double x, double low_y = 0, double high_y = 1) const;
  // 5 x 5 cells around (x, y) [m].
  double bed_height(double x, double y) const;
  struct DepthBin {
    double x, height, streamwise, solid_fraction;  // m, m, m/s, 1
  };
  std::vector<DepthBin> depth_profile() const;

  double particle_steps() const { return particle_steps_; }
  double cpu_seconds() const { return cpu_seconds_; }
  double ledger_remainder() const { return ledger_remainder_; }

 private:
  const core::Table& field(const std::string& name) const;
  double mean_over_cells(const std::string& column, double x, double low_y, double high_y) const;

  core::Observation observation_;
  double particle_steps_ = 0;
  double cpu_seconds_ = 0;
  double ledger_remainder_ = 0;
};

// Rows of a reference table: first line names, then numbers; cells that are no numbers read as NaN.
using CsvRow = std::map<std::string, double>;
std::vector<CsvRow> read_csv(const std::filesystem::path& path);

}  // namespace granary::tests
