#include "worker/scene/discharge_simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "worker/dda/penalty_growth.h"
#include "worker/dda/step.h"
#include "worker/dda/step_energy.h"

namespace granary::scene {
namespace {

using std::numbers::pi;

constexpr double kSettledShare = 1e-6;    // kinetic energy / its peak (PHYSICS section E 3)
constexpr double kLongestFilling = 5;     // s, then the run goes on with a warning
constexpr double kExpectedFilling = 0.8;  // s, for the progress bar only
constexpr double kLongestLanding = 5;     // s after the end angle; what flies then never lands
constexpr double kFillingShare = 0.5;     // of the progress bar
constexpr double kRotationShare = 0.45;

// A step near `wanted` of which `duration` is a whole multiple.
double fitting_step(double duration, double wanted) {
  return duration / std::max(1.0, std::ceil(duration / wanted - 1e-9));
}

dda::Vec2 mass_centre(const dda::Disks& disks) {
  double mass = 0;
  dda::Vec2 sum;
  for (std::size_t k = 0; k < disks.count(); ++k) {
    const double m = 1 / disks.motion[k].inverse_mass;
    mass += m;
    sum = sum + m * dda::Vec2{disks.pose[k].x, disks.pose[k].y};
  }
  return (1 / mass) * sum;
}

}  // namespace

std::string_view to_string(DischargePhase phase) {
  constexpr std::string_view names[] = {"filling", "run-up", "rotation", "landing", "finished"};
  return names[static_cast<std::size_t>(phase)];
}

DischargeSimulation::DischargeSimulation(DischargePlan plan, const core::State* stored_filling)
    : plan_(std::move(plan)) {
  system_.contact = plan_.contact;
  system_.gravity = plan_.gravity;
  system_.damping_rate = plan_.damping_rate;
  system_.drive.pulley_radius = plan_.pulley_radius;
  if (plan_.bucket) {
    system_.walls.add_chain(plan_.bucket->outer_wall, true);
    system_.walls.add_chain(plan_.bucket->inner_wall, true);
  }
  for (const auto& wall : plan_.moving_walls) system_.walls.add_chain(wall, true);
  for (const auto& wall : plan_.fixed_walls) system_.walls.add_chain(wall, false);

  if (plan_.filling == DischargePlan::Filling::placed) {
    system_.disks = plan_.placed_disks;
    record_.placed_count = system_.disks.count();
    begin_motion();
  } else if (stored_filling != nullptr) {
    filling_ = *stored_filling;
    begin_motion();
  } else if (plan_.filling == DischargePlan::Filling::stored) {
    throw std::invalid_argument(
        "discharge.stored_filling: the filling is not there; jobs of a server bring it along");
  } else {
    begin_filling();
  }
}

void DischargeSimulation::start_phase(DischargePhase phase, double start_time, double time_step) {
  phase_ = phase;
  phase_start_ = start_time;
  phase_steps_ = 0;
  choose_books();
  system_.time = start_time;
  system_.time_step = time_step;
}

// Fillings use the impulse solver and backward Euler whatever the scene asks for: open-close
// iterations need too many rounds in a falling pack, Newmark's trapezoid never comes to rest
// (PHYSICS section F), and solvers are compared from one and the same bed.
void DischargeSimulation::choose_solver() {
  const bool fills = phase_ == DischargePhase::filling;
  system_.solver = plan_.solver;
  if (fills) system_.solver = {.tolerance = plan_.filling_tolerance};
  system_.penalty = fills ? dda::PenaltyGrowth{} : plan_.penalty;
}

// A filling's ledger is opened anew when the bucket starts to move, so nobody reads its channels.
// That energies can but fall watches it well enough, except where bridges pull disks together.
void DischargeSimulation::choose_books() {
  system_.keeps_books = phase_ != DischargePhase::filling || system_.contact.effects.cohesion;
}

void DischargeSimulation::begin_filling() {
  system_.disks = plan_.filling == DischargePlan::Filling::drop
                      ? drop_array(plan_.disk_kind, *plan_.bucket)
                      : compact_order(plan_.disk_kind, *plan_.bucket);
  record_.placed_count = plan_.disk_kind.count;
  choose_solver();
  system_.contact.stiffness = plan_.filling_stiffness;
  dda::reset_contacts(system_);
  start_phase(DischargePhase::filling, 0, plan_.filling_time_step);
}

void DischargeSimulation::end_filling() {
  const bool settled = system_.report.kinetic_energy <= kSettledShare * peak_kinetic_energy_;
  filling_ = store_filling(system_, *plan_.bucket, record_.placed_count, settled);
  begin_motion();
}

void DischargeSimulation::begin_motion() {
  const bool placed = plan_.filling == DischargePlan::Filling::placed;
  phase_ = DischargePhase::rotation;
  choose_solver();
  system_.contact.stiffness =
      placed ? plan_.contact.stiffness : filling_->get_scalar<double>("stiffness");
  if (placed) {
    dda::reset_contacts(system_);
  } else {
    load_filling(*filling_, system_);
    record_.placed_count = filling_->get_scalar<std::uint64_t>("placed_count");
    record_.settled = filling_->get_scalar<std::uint8_t>("settled") != 0;
  }
  const dda::Vec2 cg = mass_centre(system_.disks);
  const double lever = length(cg);
  double& omega = system_.drive.rotation_rate;
  omega = plan_.rademacher_ka ? std::sqrt(*plan_.rademacher_ka * plan_.gravity / lever)
                              : plan_.rotation_rate;
  system_.belt_runs = true;
  record_.rademacher_ka = plan_.gravity > 0 ? omega * omega * lever / plan_.gravity : 0;
  record_.initial_count = system_.disks.count();
  record_.initial_mass = 0;
  const bool moves_with_belt = !placed && omega > 0;
  const double belt_speed = system_.drive.belt_speed();
  for (std::size_t k = 0; k < system_.disks.count(); ++k) {
    dda::DiskPose& pose = system_.disks.pose[k];
    dda::DiskMotion& v = system_.disks.motion[k];
    record_.initial_mass += 1 / v.inverse_mass;
    if (!moves_with_belt) continue;
    if (plan_.run_up > 0) pose.y -= plan_.run_up;
    v = plan_.starts_with_belt_velocity ? dda::DiskMotion{0, belt_speed, 0, v.inverse_mass}
                                        : dda::DiskMotion{omega * pose.y, -omega * pose.x,
                                                          -omega * pose.radius, v.inverse_mass};
  }
  record_.landing_x.assign(system_.disks.count(), std::numeric_limits<double>::quiet_NaN());
  record_.landed_inside.assign(system_.disks.count(), 0);
  record_.in_target.assign(system_.disks.count(), 0);
  dda::open_ledger(system_);
  if (system_.contact.stiffness != plan_.contact.stiffness)
    dda::change_penalty(system_, plan_.contact.stiffness);
  if (moves_with_belt && plan_.run_up > 0) {
    const double duration = plan_.run_up / belt_speed;
    start_phase(DischargePhase::run_up, -duration, fitting_step(duration, plan_.time_step));
  } else {
    start_phase(DischargePhase::rotation, 0, fitting_step(end_time(), plan_.time_step));
    if (plan_.bucket) sample_discharge(system_, *plan_.bucket, true, record_);
  }
}

double DischargeSimulation::end_time() const {
  if (plan_.duration) return *plan_.duration;
  return plan_.end_angle / system_.drive.rotation_rate;
}

bool DischargeSimulation::has_landing() const {
  return plan_.bucket && !plan_.duration && system_.drive.rotation_rate > 0 &&
         plan_.end_angle >= pi;
}

// Disks that fell past the foot of the bucket are lost to it; they must not hold up its settling.
void DischargeSimulation::drop_spilled() {
  for (std::size_t k = 0; k < system_.disks.count(); ++k)
    if (system_.disks.pose[k].y < -2 * system_.disks.pose[k].radius) system_.disks.landed[k] = 1;
}

void DischargeSimulation::after_filling_step() {
  drop_spilled();
  const double energy = system_.report.kinetic_energy;
  peak_kinetic_energy_ = std::max(peak_kinetic_energy_, energy);
  if (energy < kSettledShare * peak_kinetic_energy_ || system_.time >= kLongestFilling)
    end_filling();
}

// The target may lie below the landing level: disks then fall on to its lowest point.
LandingLevels DischargeSimulation::landing_levels() const {
  LandingLevels levels{-plan_.pulley_radius, -plan_.pulley_radius};
  for (const dda::Vec2 point : plan_.target) levels.floor = std::min(levels.floor, point.y);
  return levels;
}

void DischargeSimulation::note_flight() {
  if (plan_.bucket && !plan_.target.empty())
    note_target(system_, *plan_.bucket, plan_.target, record_);
  if (!plan_.air) return;
  mark_flying(system_, plan_.bucket ? &*plan_.bucket : nullptr, flying_);
  slow_flying_disks(system_, *plan_.air, flying_);
}

void DischargeSimulation::after_rotation_step() {
  if (plan_.bucket) {
    sample_discharge(system_, *plan_.bucket, false, record_);
    if (has_landing()) note_landings(system_, *plan_.bucket, landing_levels(), record_);
  }
  if (system_.time < end_time() - 0.5 * system_.time_step) return;
  if (plan_.bucket) close_record(system_, *plan_.bucket, record_);
  start_phase(has_landing() ? DischargePhase::landing : DischargePhase::finished, system_.time,
              system_.time_step);
}

void DischargeSimulation::after_step() {
  system_.time = phase_start_ + static_cast<double>(++phase_steps_) * system_.time_step;
  if (phase_ != DischargePhase::filling) note_flight();
  switch (phase_) {
    case DischargePhase::filling:
      return after_filling_step();
    case DischargePhase::run_up:
      if (system_.time < -0.5 * system_.time_step) return;
      start_phase(DischargePhase::rotation, 0, fitting_step(end_time(), plan_.time_step));
      sample_discharge(system_, *plan_.bucket, true, record_);
      return;
    case DischargePhase::rotation:
      return after_rotation_step();
    case DischargePhase::landing: {
      note_landings(system_, *plan_.bucket, landing_levels(), record_);
      const auto& landed = system_.disks.landed;
      if (std::find(landed.begin(), landed.end(), 0) == landed.end() ||
          system_.time > end_time() + kLongestLanding)
        start_phase(DischargePhase::finished, system_.time, system_.time_step);
      return;
    }
    case DischargePhase::finished:
      return;
  }
}

core::AdvanceOutcome DischargeSimulation::advance(double until_time_s, std::uint64_t max_steps) {
  for (std::uint64_t k = 0; k < max_steps; ++k) {
    if (phase_ == DischargePhase::finished) return {core::AdvanceStatus::finished, {}};
    if (shown_time() >= until_time_s) break;
    dda::step(system_);
    if (auto rejection = check_sentinels()) return {core::AdvanceStatus::rejected, rejection};
    after_step();
  }
  if (phase_ == DischargePhase::finished) return {core::AdvanceStatus::finished, {}};
  return {};
}

// Bound on the seconds of the run-up, also where the speed is only known after the filling: the cg
// lies within a few pulley radii of the axis.
double DischargeSimulation::longest_run_up() const {
  if (plan_.run_up == 0) return 0;
  const double slowest =
      plan_.rademacher_ka
          ? std::sqrt(*plan_.rademacher_ka * plan_.gravity / (10 * plan_.pulley_radius))
          : plan_.rotation_rate;
  return slowest > 0 ? plan_.run_up / (slowest * plan_.pulley_radius) : 0;
}

// Filling has its own clock; it is shown as negative times that end before the motion starts.
double DischargeSimulation::shown_time() const {
  if (phase_ != DischargePhase::filling) return system_.time;
  return system_.time - kLongestFilling - longest_run_up();
}

core::SimulationProgress DischargeSimulation::progress() const {
  core::SimulationProgress progress;
  const double filling = filling_ ? kFillingShare : 0;
  switch (phase_) {
    case DischargePhase::filling:
      progress.fraction = kFillingShare * std::min(1.0, system_.time / kExpectedFilling);
      break;
    case DischargePhase::run_up:
      progress.fraction = filling;
      break;
    case DischargePhase::rotation:
      progress.fraction =
          filling + (has_landing() ? kRotationShare : 1 - filling) * system_.time / end_time();
      break;
    case DischargePhase::landing:
      progress.fraction = filling + kRotationShare;
      break;
    case DischargePhase::finished:
      progress.fraction = 1;
      break;
  }
  progress.phase = to_string(phase_);
  progress.time_s = shown_time();
  progress.end_time_s = phase_ == DischargePhase::filling ? 0 : end_time();
  progress.steps = system_.counters.steps;
  progress.particle_steps = system_.counters.disk_steps;
  progress.particles = system_.disks.count();
  progress.contacts = system_.report.contacts;
  if (phase_ != DischargePhase::filling)
    for (const core::ObservedValue& value : observe().values)
      if (value.value) progress.current_values.emplace_back(value.name, *value.value);
  return progress;
}

std::vector<core::PhaseSeconds> DischargeSimulation::profile() const {
  std::vector<core::PhaseSeconds> profile;
  for (std::size_t k = 0; k < dda::kStepPhaseCount; ++k)
    profile.push_back(
        {std::string(to_string(static_cast<dda::StepPhase>(k))), system_.phase_seconds[k]});
  return profile;
}

}  // namespace granary::scene
