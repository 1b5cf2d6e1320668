#include "worker/measure/chute_observer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "worker/core/blocking.h"
#include "worker/measure/frame_time.h"

namespace granary::measure {
namespace {

using core::make_column;
using core::ObservedValue;

constexpr double kStationWindow = 0.03;                      // m along x
constexpr double kSensorLines[] = {0.0175, 0.0475, 0.0675};  // m across
constexpr const char* kSensorNames[] = {"y17mm", "y47mm", "y67mm"};
constexpr double kSliceWidth = 0.025;  // m, of the solid-fraction strips
constexpr std::size_t kLeaverColumns = 8;

std::vector<double> stations_of(double length) {
  std::vector<double> stations;
  for (const double x : {0.2, 0.4, 0.6, 0.8}) {
    if (x + kStationWindow / 2 <= length) stations.push_back(x);
  }
  return stations;
}

DepthWindows at_stations(std::size_t count, double low_y, double high_y) {
  return {0.2, 0.2, kStationWindow, count, low_y, high_y};
}

DepthWindows strip(double length, double low_y, double high_y) {
  const double step = ChuteSurface::kCellLength;
  return {step / 2, step, step, static_cast<std::size_t>(length / step), std::max(0.0, low_y),
          high_y};
}

std::string station_name(double station, const std::string& what, const std::string& rest) {
  return what + "_x" + std::to_string(std::lround(1000 * station)) + "mm_" + rest;
}

}  // namespace

ChuteObserver::ChuteObserver(const ChuteGeometry& g, double sample_start, bool is_mixture)
    : geometry_(g),
      sample_start_(earliest_of(sample_start)),
      is_mixture_(is_mixture),
      stations_(stations_of(g.length)),
      surface_(g.length, g.width),
      depth_(at_stations(stations_.size(), 0, g.width)),
      depth_low_(at_stations(stations_.size(), 0, g.width / 2)),
      depth_high_(at_stations(stations_.size(), g.width / 2, g.width)),
      slice_low_(strip(g.length, 0, std::min(kSliceWidth, g.width))),
      slice_centre_(strip(g.length, (g.width - kSliceWidth) / 2, (g.width + kSliceWidth) / 2)),
      slice_high_(strip(g.length, g.width - kSliceWidth, g.width)),
      segregation_(g.length, g.width) {
  name_series();
}

void ChuteObserver::name_series() {
  series_ = {{"particle_count", "1", {}},
             {"mass_flow_kg_per_s", "kg/s", {}},
             {"exit_speed_m_per_s", "m/s", {}}};
  for (const double x : stations_) {
    series_.push_back({station_name(x, "mass_flow", "kg_per_s"), "kg/s", {}});
    series_.push_back({station_name(x, "surface_velocity", "m_per_s"), "m/s", {}});
    for (const char* line : kSensorNames) {
      series_.push_back({station_name(x, "bed_height", std::string(line) + "_m"), "m", {}});
    }
  }
}

// ------------------------------------------------------------------------------------- one frame

bool ChuteObserver::is_inside(const dem::GrainTable& grains, std::size_t k) const {
  const double x = grains.position[k].x;
  return grains.carried[k] == 0 && x >= 0 && x <= geometry_.length;
}

void ChuteObserver::sample(double time, const dem::GrainTable& grains,
                           std::span<const dem::Leaver> leavers) {
  surface_.look(grains);
  record_leavers(time, leavers);
  record_grains(grains);
  times_.push_back(time);
  leavers_.insert(leavers_.end(), leavers.begin(), leavers.end());
  if (time < sample_start_) return;
  surface_.accumulate();
  for (ChuteDepth* depth :
       {&depth_, &depth_low_, &depth_high_, &slice_low_, &slice_centre_, &slice_high_}) {
    depth->accumulate(grains);
  }
  if (is_mixture_) segregation_.accumulate(grains);
}

void ChuteObserver::record_leavers(double time, std::span<const dem::Leaver> leavers) {
  double mass = 0;
  double speed = 0;
  for (const dem::Leaver& leaver : leavers) {
    mass += leaver.mass;
    speed += norm(leaver.velocity);
  }
  const double span = times_.empty() ? time : time - times_.back();
  series_[kMassFlow].rows.push_back(span > 0 ? mass / span : 0);
  series_[kExitSpeed].rows.push_back(
      leavers.empty() ? 0 : speed / static_cast<double>(leavers.size()));
}

void ChuteObserver::record_grains(const dem::GrainTable& grains) {
  double count = 0;
  std::vector<double> flux(stations_.size());
  for (std::size_t k = 0; k < grains.size(); ++k) {
    if (!is_inside(grains, k)) continue;
    ++count;
    for (std::size_t s = 0; s < stations_.size(); ++s) {
      if (std::abs(grains.position[k].x - stations_[s]) > kStationWindow / 2) continue;
      flux[s] += grains.mass[k] * grains.velocity[k].x / kStationWindow;
    }
  }
  series_[kCount].rows.push_back(count);
  for (std::size_t s = 0; s < stations_.size(); ++s) {
    const std::size_t first = station_series(s);
    series_[first + kFlux].rows.push_back(flux[s]);
    series_[first + kVelocity].rows.push_back(surface_.streamwise_at(stations_[s]));
    for (std::size_t line = 0; line < std::size(kSensorLines); ++line) {
      series_[first + kHeights + line].rows.push_back(
          surface_.sensor_height(stations_[s], kSensorLines[line]));
    }
  }
}

std::size_t ChuteObserver::particle_count() const {
  const auto& rows = series_[kCount].rows;
  return rows.empty() ? 0 : static_cast<std::size_t>(rows.back());
}

std::vector<std::pair<std::string, double>> ChuteObserver::current_values() const {
  if (times_.empty()) return {};
  return {{"particle_count", series_[kCount].rows.back()},
          {"mass_flow_kg_per_s", series_[kMassFlow].rows.back()},
          {"exit_speed_m_per_s", series_[kExitSpeed].rows.back()}};
}

// ----------------------------------------------------------------------------------- time means

std::vector<double> ChuteObserver::steady_rows(std::size_t index) const {
  const auto first = std::lower_bound(times_.begin(), times_.end(), sample_start_) - times_.begin();
  const auto& rows = series_[index].rows;
  return {rows.begin() + first, rows.end()};
}

ObservedValue ChuteObserver::mean_value(std::size_t index) const {
  const Series& series = series_[index];
  ObservedValue value{series.name, series.unit, std::nullopt, std::nullopt,
                      "no frame in the sampling time"};
  const std::vector<double> rows = steady_rows(index);
  if (rows.empty()) return value;
  const core::MeanWithError mean = core::blocked_mean(rows);
  value.value = mean.mean;
  value.error = mean.half_width;
  value.error_basis = mean.half_width ? "blocking over " + std::to_string(rows.size()) + " frames"
                                      : "too few frames for an interval";
  return value;
}

// The value comes from the time means by cell, as the fields do; the interval from the frames.
ObservedValue ChuteObserver::table_value(std::size_t index, double from_table) const {
  ObservedValue value = mean_value(index);
  if (value.value) value.value = from_table;
  return value;
}

ObservedValue ChuteObserver::exit_speed() const {
  ObservedValue value{series_[kExitSpeed].name, "m/s", std::nullopt, std::nullopt,
                      "no grain left in the sampling time"};
  double sum = 0;
  double count = 0;
  for (const dem::Leaver& leaver : leavers_) {
    if (leaver.time < sample_start_) continue;
    sum += norm(leaver.velocity);
    ++count;
  }
  if (count == 0) return value;
  value.value = sum / count;
  std::vector<double> rows = steady_rows(kExitSpeed);
  std::erase(rows, 0.0);
  value.error = core::blocked_mean(rows).half_width;
  value.error_basis = value.error ? "blocking over the frames" : "too few frames for an interval";
  return value;
}

// Frames before sample_start count here: this value says where sampling could have begun.
ObservedValue ChuteObserver::steady_time() const {
  ObservedValue value{"steady_from_s", "s", std::nullopt, std::nullopt,
                      "particle_count shows no steady part"};
  const auto row = core::steady_from(series_[kCount].rows);
  if (!row) return value;
  value.value = times_[*row];
  value.error_basis = "first frame that MSER-5 keeps of particle_count";
  return value;
}

core::Observation ChuteObserver::observe() const {
  core::Observation observation;
  observation.values = {mean_value(kCount), mean_value(kMassFlow), exit_speed(), steady_time()};
  for (std::size_t s = 0; s < stations_.size(); ++s) {
    const std::size_t first = station_series(s);
    observation.values.push_back(mean_value(first + kFlux));
    observation.values.push_back(
        table_value(first + kVelocity, surface_.mean_streamwise_at(stations_[s])));
    for (std::size_t line = 0; line < std::size(kSensorLines); ++line) {
      observation.values.push_back(table_value(
          first + kHeights + line, surface_.mean_sensor_height(stations_[s], kSensorLines[line])));
    }
  }
  if (is_mixture_) {
    for (ObservedValue& value : segregation_.values()) {
      observation.values.push_back(std::move(value));
    }
  }
  const ObservedValue& steady = observation.values[3];
  if (!times_.empty() && times_.back() >= sample_start_ &&
      (!steady.value || *steady.value > sample_start_)) {
    observation.warnings.push_back("the particle count was not yet steady at sample_start_s");
  }
  observation.series = {flow_table()};
  observation.fields = field_tables();
  return observation;
}

// --------------------------------------------------------------------------------------- tables

core::Table ChuteObserver::flow_table() const {
  core::Table table{"flow", {make_column<double>("time_s", "s", times_)}};
  for (const Series& series : series_) {
    table.columns.push_back(make_column<double>(series.name, series.unit, series.rows));
  }
  return table;
}

core::Table ChuteObserver::leaver_table() const {
  std::vector<double> columns[kLeaverColumns];
  for (const dem::Leaver& l : leavers_) {
    const double row[kLeaverColumns] = {l.time,       l.position.x, l.position.y, l.position.z,
                                        l.velocity.x, l.velocity.y, l.velocity.z, l.diameter};
    for (std::size_t k = 0; k < kLeaverColumns; ++k) columns[k].push_back(row[k]);
  }
  constexpr const char* names[] = {"time_s",     "x_m",        "y_m",        "z_m",
                                   "vx_m_per_s", "vy_m_per_s", "vz_m_per_s", "diameter_m"};
  constexpr const char* units[] = {"s", "m", "m", "m", "m/s", "m/s", "m/s", "m"};
  core::Table table{"leaving_grains", {}};
  for (std::size_t k = 0; k < kLeaverColumns; ++k) {
    table.columns.push_back(make_column<double>(names[k], units[k], columns[k]));
  }
  return table;
}

std::vector<core::Table> ChuteObserver::field_tables() const {
  return {surface_.velocity_table(),
          surface_.height_table(),
          depth_.table("depth_profile"),
          surface_.spanwise_table(stations_),
          depth_low_.table("depth_profile_low_y"),
          depth_high_.table("depth_profile_high_y"),
          slice_low_.table("solid_fraction_low_y"),
          slice_centre_.table("solid_fraction_centre"),
          slice_high_.table("solid_fraction_high_y"),
          leaver_table()};
}

// ----------------------------------------------------------------------------------- checkpoints

void ChuteObserver::save(core::State& state) const {
  state.put("observer.times_s", "s", times_);
  for (const Series& series : series_) state.put("observer." + series.name, series.unit, series.rows);
  std::vector<double> leavers;
  std::vector<std::int64_t> ids;
  for (const dem::Leaver& l : leavers_) {
    leavers.insert(leavers.end(), {l.time, l.position.x, l.position.y, l.position.z, l.velocity.x,
                                   l.velocity.y, l.velocity.z, l.diameter, l.mass});
    ids.push_back(l.id);
  }
  state.put("observer.leavers", "SI", leavers, kLeaverColumns + 1);
  state.put("observer.leaver_ids", "1", ids);
  surface_.save(state);
  depth_.save(state, "depth");
  depth_low_.save(state, "depth_low_y");
  depth_high_.save(state, "depth_high_y");
  slice_low_.save(state, "slice_low_y");
  slice_centre_.save(state, "slice_centre");
  slice_high_.save(state, "slice_high_y");
  segregation_.save(state);
}

void ChuteObserver::load(const core::State& state) {
  times_ = state.get<double>("observer.times_s");
  for (Series& series : series_) {
    series.rows = state.get<double>("observer." + series.name);
    if (series.rows.size() != times_.size()) throw std::runtime_error("state: series differ in length");
  }
  const auto rows = state.get<double>("observer.leavers");
  const auto ids = state.get<std::int64_t>("observer.leaver_ids");
  leavers_.clear();
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const double* r = &rows[k * (kLeaverColumns + 1)];
    leavers_.push_back({r[0], ids[k], {r[1], r[2], r[3]}, {r[4], r[5], r[6]}, r[7], r[8]});
  }
  surface_.load(state);
  depth_.load(state, "depth");
  depth_low_.load(state, "depth_low_y");
  depth_high_.load(state, "depth_high_y");
  slice_low_.load(state, "slice_low_y");
  slice_centre_.load(state, "slice_centre");
  slice_high_.load(state, "slice_high_y");
  segregation_.load(state);
}

}  // namespace granary::measure
