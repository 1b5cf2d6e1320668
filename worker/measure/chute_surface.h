// The bed seen from above, in cells of 6 mm (x) by 5 mm (y) as the chute paper measures it (PHYSICS
// section H3). Of a cell and frame: bed height = top of its highest grain, 0 where empty; surface
// velocity = mean of its topmost six grains, if it holds at least three. Means over frames: height
// over all of them, velocity over those where it exists.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/core/simulation.h"
#include "worker/dem/grains.h"

namespace granary::measure {

class ChuteSurface {
 public:
  static constexpr double kCellLength = 0.006;  // m, along x
  static constexpr double kCellWidth = 0.005;   // m, along y
  static constexpr std::size_t kTopGrains = 6;
  static constexpr std::size_t kFewestGrains = 3;

  struct Cell {
    double height = 0;
    double streamwise = 0;
    double spanwise = 0;
    bool has_velocity = false;
  };

  ChuteSurface(double length, double width);

  // Looks at one frame: free grains inside the chute.
  void look(const dem::GrainTable& grains);
  // Adds the frame looked at last to the means.
  void accumulate();

  // Of the frame looked at last: over the five cells in x around `x`; every cell of the width for the
  // velocity, five cells in y around `y` for the height sensor. 0 where there is no velocity.
  double streamwise_at(double x) const;
  double sensor_height(double x, double y) const;
  // The same of the time means.
  double mean_streamwise_at(double x) const;
  double mean_sensor_height(double x, double y) const;

  core::Table velocity_table() const;  // surface_velocity: x_m, y_m, streamwise, spanwise
  core::Table height_table() const;    // bed_height: x_m, y_m, height_m
  // spanwise_profile at the given stations: mean over five cells in x.
  core::Table spanwise_table(const std::vector<double>& stations) const;

  void save(core::State& state) const;
  void load(const core::State& state);

 private:
  std::size_t index(std::size_t ix, std::size_t iy) const { return ix * across_ + iy; }
  Cell mean_cell(std::size_t cell) const;
  struct Range {
    std::size_t first, end;
  };
  Range five_along(double x) const;
  Range five_across(double y) const;
  template <typename CellAt>
  double streamwise_over(double x, CellAt cell_at) const;
  template <typename CellAt>
  double height_over(double x, double y, CellAt cell_at) const;

  std::size_t along_;
  std::size_t across_;
  double length_;
  double width_;
  std::vector<Cell> frame_;
  std::uint64_t frames_ = 0;
  std::vector<double> height_sum_;
  std::vector<double> streamwise_sum_;
  std::vector<double> spanwise_sum_;
  std::vector<std::uint64_t> velocity_frames_;
};

}  // namespace granary::measure
