// Everything that is measured on a chute while it runs (PHYSICS section H): series, time means with
// 95 % intervals by blocking, the log of leaving grains. Reads grains, changes nothing.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "worker/core/simulation.h"
#include "worker/dem/grains.h"
#include "worker/measure/chute_depth.h"
#include "worker/measure/chute_segregation.h"
#include "worker/measure/chute_surface.h"

namespace granary::measure {

struct ChuteGeometry {
  double length = 0.9;  // m
  double width = 0.08;  // m
};

class ChuteObserver {
 public:
  ChuteObserver(const ChuteGeometry& geometry, double sample_start, bool is_mixture);

  // One frame; means take it when time >= sample_start. Leavers: since the last frame.
  void sample(double time, const dem::GrainTable& grains, std::span<const dem::Leaver> leavers);

  // Sensors of the paper stand at these x where the chute is long enough [m].
  const std::vector<double>& stations() const { return stations_; }

  std::size_t particle_count() const;  // free grains with 0 <= x <= length, last frame
  // Values, tables and warnings; effect counts are the engine's to add.
  core::Observation observe() const;
  // mass_flow_kg_per_s and particle_count of the last frame, for a progress line.
  std::vector<std::pair<std::string, double>> current_values() const;

  void save(core::State& state) const;
  void load(const core::State& state);

 private:
  // One column per observable, one row per frame; rows are never dropped.
  struct Series {
    std::string name;
    std::string unit;
    std::vector<double> rows;
  };
  enum FixedSeries : std::size_t { kCount, kMassFlow, kExitSpeed, kFixedSeries };
  enum StationSeries : std::size_t { kFlux, kVelocity, kHeights, kPerStation = kHeights + 3 };
  std::size_t station_series(std::size_t station) const { return kFixedSeries + station * kPerStation; }
  void name_series();
  void record_grains(const dem::GrainTable& grains);
  void record_leavers(double time, std::span<const dem::Leaver> leavers);
  bool is_inside(const dem::GrainTable& grains, std::size_t k) const;
  std::vector<double> steady_rows(std::size_t series) const;
  core::ObservedValue mean_value(std::size_t series) const;
  core::ObservedValue table_value(std::size_t series, double from_table) const;
  core::ObservedValue exit_speed() const;
  core::ObservedValue steady_time() const;
  core::Table flow_table() const;
  core::Table leaver_table() const;
  std::vector<core::Table> field_tables() const;

  ChuteGeometry geometry_;
  double sample_start_;
  bool is_mixture_;
  std::vector<double> stations_;
  ChuteSurface surface_;
  ChuteDepth depth_;
  ChuteDepth depth_low_;   // y < width / 2
  ChuteDepth depth_high_;  // y >= width / 2
  ChuteDepth slice_low_;   // 25 mm strips of the solid fraction
  ChuteDepth slice_centre_;
  ChuteDepth slice_high_;
  ChuteSegregation segregation_;
  std::vector<Series> series_;
  std::vector<double> times_;
  std::vector<dem::Leaver> leavers_;
};

}  // namespace granary::measure
