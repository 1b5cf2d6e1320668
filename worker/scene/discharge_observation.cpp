// Results of a discharge: named values, tables and the columns of a frame.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "worker/scene/discharge_simulation.h"

namespace granary::scene {
namespace {

using core::make_column;
using core::ObservedValue;
using std::numbers::pi;

constexpr std::string_view kOneRun = "one run: the spread between fillings is not known";

class Values {
 public:
  void add(std::string name, std::string unit, std::optional<double> value,
           std::string basis = std::string(kOneRun)) {
    values_.push_back({std::move(name), std::move(unit), value, {}, std::move(basis)});
  }
  std::vector<ObservedValue> take() { return std::move(values_); }

 private:
  std::vector<ObservedValue> values_;
};

// What Table 1 of the bucket paper shows of its growing penalty, per metre of depth as it is given.
void add_open_close(const dda::System& system, double axial_depth, Values& values) {
  values.add("penalty_final_n_per_m", "N/m", system.contact.stiffness / axial_depth);
  values.add("open_close_iterations", "1",
             static_cast<double>(system.counters.open_close_iterations));
}

std::vector<measure::FlyingDisk> flying_now(const dda::System& system,
                                            const dda::BucketGeometry& bucket) {
  std::vector<measure::FlyingDisk> flying;
  for (std::size_t k = 0; k < system.disks.count(); ++k)
    if (system.disks.landed[k] || !disk_in_bucket(system, bucket, k))
      flying.push_back({system.disks.pose[k].x, system.disks.pose[k].y,
                        1 / system.disks.motion[k].inverse_mass});
  return flying;
}

void add_flight(const DischargeRecord& record, const std::vector<measure::FlyingDisk>& flying,
                Values& values) {
  const auto flight = measure::flight_values(flying, record.initial_count);
  const auto basis = std::string(flight ? kOneRun : "fewer than 5 % of the disks fly");
  const auto pick = [&](double measure::FlightValues::*member) {
    return flight ? std::optional((*flight).*member) : std::nullopt;
  };
  values.add("f1_m", "m", pick(&measure::FlightValues::centre_x), basis);
  values.add("f2_m", "m", pick(&measure::FlightValues::distance), basis);
  values.add("f3_percent", "%",
             100.0 *
                 (static_cast<double>(record.initial_count) - static_cast<double>(flying.size())) /
                 static_cast<double>(record.initial_count));
  values.add("f4_m", "m", pick(&measure::FlightValues::spread), basis);
}

void add_landing(const dda::System& system, const DischargeRecord& record, Values& values) {
  const auto landing = measure::landing_values(landed_disks(system, record), record.initial_count);
  const auto basis = std::string(landing ? kOneRun : "fewer than 5 % of the disks landed");
  values.add("f1_landing_m", "m", landing ? std::optional(landing->mean_x) : std::nullopt, basis);
  values.add("f4_landing_m", "m", landing ? std::optional(landing->half_width) : std::nullopt,
             basis);
}

void add_target(const DischargeRecord& record, Values& values) {
  const LandingShares shares = landing_shares(record);
  const double percent = 100 / static_cast<double>(record.initial_count);
  values.add("target_percent", "%", percent * static_cast<double>(shares.target));
  values.add("leg_percent", "%", percent * static_cast<double>(shares.leg));
}

void add_shares(const DischargeRecord& record, Values& values) {
  for (const auto& [name, share] :
       {std::pair{"a5_deg", 0.05}, {"a50_deg", 0.5}, {"a95_deg", 0.95}}) {
    const auto angle =
        measure::angle_of_share_left(record.sample_angle_deg, record.sample_remaining, share);
    values.add(name, "deg", angle, angle ? std::string(kOneRun) : "that share has not left");
  }
}

core::Table remaining_table(const DischargeRecord& record) {
  std::vector<double> time, angle, remaining;
  const double last = record.sample_angle_deg.empty() ? -1 : record.sample_angle_deg.back();
  for (double degree = 0; degree <= last + 1e-6; degree += 1) {
    angle.push_back(degree);
    time.push_back(measure::interpolate(record.sample_angle_deg, record.sample_time, degree));
    remaining.push_back(
        100 * measure::interpolate(record.sample_angle_deg, record.sample_remaining, degree) /
        static_cast<double>(record.initial_count));
  }
  return {"remaining",
          {make_column<double>("time_s", "s", time), make_column<double>("angle_deg", "deg", angle),
           make_column<double>("remaining_percent", "%", remaining)}};
}

core::Table cg_table(const DischargeRecord& record) {
  return {"cg",
          {make_column<double>("time_s", "s", record.sample_time),
           make_column<double>("angle_deg", "deg", record.sample_angle_deg),
           make_column<double>("x_m", "m", record.sample_cg_x),
           make_column<double>("y_m", "m", record.sample_cg_y)}};
}

// The bucket walls at theta = 0, one row per point: turn them clockwise by theta about the origin.
core::Table bucket_table(const dda::BucketGeometry& bucket) {
  std::vector<double> x, y;
  std::vector<std::uint32_t> wall;
  for (const auto* line : {&bucket.outer_wall, &bucket.inner_wall})
    for (const dda::Vec2 point : *line) {
      x.push_back(point.x);
      y.push_back(point.y);
      wall.push_back(line == &bucket.outer_wall ? 0 : 1);
    }
  return {"bucket",
          {make_column<double>("x_m", "m", x), make_column<double>("y_m", "m", y),
           make_column<std::uint32_t>("wall", "1", wall)}};
}

// Energy that raising the penalty under load has put into the bed comes out as speed: worth a word
// from 2 % of the belt speed on.
constexpr double kWarnedSpeedShare = 0.02;

void warn_of_penalty(const dda::System& system, const DischargeRecord& record,
                     std::vector<std::string>& warnings) {
  const double added = -system.ledger[core::EnergyChannel::penalty_change];
  if (added <= 0 || record.initial_mass <= 0) return;
  const double speed = std::sqrt(2 * added / record.initial_mass);
  if (speed < kWarnedSpeedShare * system.drive.belt_speed()) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "raising the penalty under load put %.2g J into the bed, enough to throw it apart at "
      "%.2g m/s: fill and run at the same penalty",
      added, speed);
  warnings.emplace_back(text);
}

std::vector<std::string> warnings_of(const dda::System& system, const DischargeRecord& record) {
  std::vector<std::string> warnings;
  warn_of_penalty(system, record, warnings);
  if (!record.settled) warnings.push_back("the filling had not come to rest when the motion began");
  const dda::StepCounters& c = system.counters;
  if (c.unconverged_steps > 0)
    warnings.push_back(std::to_string(c.unconverged_steps) + " of " + std::to_string(c.steps) +
                       " steps stopped at discharge.solver.max_iterations before their tolerance");
  if (c.open_close_iterations > 0)
    warnings.push_back("open-close: " + std::to_string(c.open_close_iterations) +
                       " iterations, the penalty grew " + std::to_string(c.penalty_growths) +
                       " times");
  return warnings;
}

}  // namespace

core::Observation DischargeSimulation::observe() const {
  core::Observation seen;
  seen.warnings = warnings_of(system_, record_);
  const dda::EffectCounts& laws = system_.counters.effects;
  seen.effect_evaluations = {{"gas", system_.counters.drag_evaluations},
                             {"rolling_friction", laws.rolling},
                             {"particle_rotation", laws.rotation},
                             {"tangential_history", laws.history},
                             {"cohesion", laws.cohesion}};
  if (plan_.bucket) seen.fields.push_back(bucket_table(*plan_.bucket));
  if (!plan_.bucket || phase_ == DischargePhase::filling || record_.initial_count == 0) return seen;
  Values values;
  add_flight(record_, record_.ended ? record_.flying_at_end : flying_now(system_, *plan_.bucket),
             values);
  add_landing(system_, record_, values);
  if (!plan_.target.empty()) add_target(record_, values);
  add_shares(record_, values);
  values.add(
      "fill_ratio", "1",
      static_cast<double>(record_.initial_count) / static_cast<double>(record_.placed_count));
  values.add("count_initial", "1", static_cast<double>(record_.initial_count));
  values.add("filled_mass_kg", "kg", record_.initial_mass);
  values.add("discharged_mass_kg", "kg",
             record_.ended ? std::optional(record_.discharged_mass) : std::nullopt);
  values.add("rademacher_ka", "1", record_.rademacher_ka);
  if (plan_.solver.method == dda::SolverMethod::open_close)
    add_open_close(system_, plan_.axial_depth, values);
  seen.values = values.take();
  seen.series = {remaining_table(record_), cg_table(record_)};
  return seen;
}

std::vector<core::ColumnView> DischargeSimulation::frame() const {
  const dda::Disks& disks = system_.disks;
  std::vector<double> position, angle, radius, velocity, spin;
  std::vector<std::uint8_t> inside;
  for (std::size_t k = 0; k < disks.count(); ++k) {
    const dda::DiskPose& p = disks.pose[k];
    const dda::DiskMotion& v = disks.motion[k];
    position.insert(position.end(), {p.x, p.y});
    angle.push_back(p.angle);
    radius.push_back(p.radius);
    velocity.insert(velocity.end(), {v.vx, v.vy});
    spin.push_back(v.surface_speed / p.radius);
    inside.push_back(plan_.bucket && !disks.landed[k] && disk_in_bucket(system_, *plan_.bucket, k));
  }
  shown_.clear();
  shown_.push_back(make_column<std::uint32_t>("id", "1", disks.id));
  shown_.push_back(make_column<double>("position_m", "m", position, 2));
  shown_.push_back(make_column<double>("angle_rad", "rad", angle));
  shown_.push_back(make_column<double>("radius_m", "m", radius));
  shown_.push_back(make_column<double>("velocity_m_per_s", "m/s", velocity, 2));
  shown_.push_back(make_column<double>("spin_rad_per_s", "rad/s", spin));
  shown_.push_back(make_column<std::uint32_t>("stratum", "1", disks.stratum));
  shown_.push_back(make_column<std::uint8_t>("inside", "1", inside));
  std::vector<core::ColumnView> views;
  for (const core::Column& column : shown_) views.push_back(core::view_of(column));
  return views;
}

std::vector<core::ColumnView> DischargeSimulation::physical_state() const {
  const dda::Disks& disks = system_.disks;
  return {{"id", "1", core::ElementType::u32, disks.count(), 1, disks.id.data()},
          {"pose", "m, m, m, rad", core::ElementType::f64, disks.count(), 4, disks.pose.data()},
          {"motion", "m/s, m/s, m/s, 1/kg", core::ElementType::f64, disks.count(), 4,
           disks.motion.data()},
          {"time_s", "s", core::ElementType::f64, 1, 1, &system_.time}};
}

}  // namespace granary::scene
