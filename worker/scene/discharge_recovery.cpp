// Sentinels of a discharge, after every step, and the settings it can change to get past a failure.
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/core/books.h"
#include "worker/scene/discharge_simulation.h"

namespace granary::scene {
namespace {

// Overlap / radius of the smaller body: beyond it a disk may slip out on the other side.
constexpr double kLargestOverlap = 0.5;
// A body that approaches by more radii in a step got in too deep because of its speed.
constexpr double kFastApproach = 0.3;
// Path of one step / radius of the smallest disk that no flying disk of a sound run reaches.
constexpr double kLongestPath = 100;
constexpr std::uint64_t kStepsBetweenMarks = 512;  // a snapshot costs about as much as one step
constexpr double kPenaltyFactor = 10;
constexpr double kToleranceFactor = 0.1;

struct DeepContact {
  double overlap_ratio = 0;  // overlap / radius of the smaller disk
  double path_ratio = 0;     // relative motion along the normal in a step / the same radius
  std::vector<std::int64_t> ids;
};

// Of the last step: how the gap of a contact changed in it, without the walls' own motion.
double path(const dda::System& system, const dda::ActiveContacts& contacts, std::size_t k) {
  const dda::DiskMotion& a = system.motion_before[static_cast<std::size_t>(contacts.first[k])];
  const dda::DiskMotion& b = system.motion_before[static_cast<std::size_t>(contacts.second[k])];
  return system.time_step * std::abs((b.vx - a.vx) * contacts.normal_x[k] +
                                     (b.vy - a.vy) * contacts.normal_y[k] + contacts.drift_n[k]);
}

void search(const dda::System& system, const dda::ActiveContacts& contacts, DeepContact& deepest) {
  const std::int32_t rest = system.disks.rest_index();
  for (std::size_t k = 0; k < contacts.size; ++k) {
    if (contacts.slot[k] < 0) continue;
    const auto first = static_cast<std::size_t>(contacts.first[k]);
    double radius = system.disks.pose[first].radius;
    std::vector<std::int64_t> ids = {system.disks.id[first]};
    if (contacts.second[k] != rest) {
      const auto second = static_cast<std::size_t>(contacts.second[k]);
      radius = std::min(radius, system.disks.pose[second].radius);
      ids.push_back(system.disks.id[second]);
    }
    const double ratio = -contacts.gap_start[k] / radius;
    if (ratio > deepest.overlap_ratio)
      deepest = {ratio, path(system, contacts, k) / radius, std::move(ids)};
  }
}

DeepContact deepest_contact(const dda::System& system) {
  DeepContact deepest;
  search(system, system.pair_contacts, deepest);
  search(system, system.wall_contacts, deepest);
  return deepest;
}

// A sweep moves a heavy body that light ones hold up by the ratio of their masses.
constexpr double kLargestSweepMassRatio = 1e3;

std::string overlap_advice(const dda::System& system) {
  const auto [lightest, heaviest] = std::minmax_element(system.mass.begin(), system.mass.end());
  const bool sweeps = system.solver.method == dda::SolverMethod::impulse;
  if (sweeps && *heaviest > kLargestSweepMassRatio * *lightest)
    return "discharge.solver.method OPEN_CLOSE: light disks hold up heavy ones";
  return "a larger discharge.penalty.stiffness_n_per_m, or a smaller discharge.time_step_s";
}

// Ids of disks that move further than `farthest` in a step, or not by a number at all. The energy
// bounds every speed, so that disks are only looked at when something is wrong.
std::vector<std::int64_t> runaways(const dda::System& system, double farthest) {
  const double dt2 = system.time_step * system.time_step;
  if (2 * system.report.kinetic_energy / system.lightest * dt2 < farthest * farthest) return {};
  std::vector<std::int64_t> ids;
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    const dda::DiskMotion& v = system.disks.motion[k];
    const double path2 = (v.vx * v.vx + v.vy * v.vy) * dt2;
    if (!system.disks.landed[k] && !(path2 <= farthest * farthest))
      ids.push_back(system.disks.id[k]);
  }
  return ids;
}

}  // namespace

std::optional<core::Rejection> DischargeSimulation::check_sentinels() const {
  if constexpr (!core::kBooks) return {};
  const double radius = system_.smallest_radius;
  if (!std::isfinite(system_.report.kinetic_energy))
    return core::Rejection{shown_time(), "the velocities are no longer finite",
                           runaways(system_, radius), "a smaller discharge.time_step_s",
                           core::Cause::not_finite};
  if (system_.report.worst_overlap > kLargestOverlap * radius) {
    const DeepContact deepest = deepest_contact(system_);
    if (deepest.overlap_ratio > kLargestOverlap)
      return core::Rejection{
          shown_time(), "overlap of " + std::to_string(deepest.overlap_ratio) + " radii",
          deepest.ids, overlap_advice(system_),
          deepest.path_ratio > kFastApproach ? core::Cause::speed : core::Cause::overlap};
  }
  const auto fast = runaways(system_, kLongestPath * radius);
  if (!fast.empty())
    return core::Rejection{
        shown_time(), "a disk moved by more than a hundred radii in one step", fast,
        "a smaller discharge.time_step_s, or discharge.solver.method IMPULSE", core::Cause::speed};
  return {};
}

std::uint64_t DischargeSimulation::steps_between_marks() const {
  return core::kBooks ? kStepsBetweenMarks : core::kNever;
}

// Sweeps that stop short of their tolerance go on in the next step, and what they left is booked;
// an open-close iteration that has not settled has no contact states at all.
std::uint64_t DischargeSimulation::unconverged_steps() const {
  const bool iterates = plan_.solver.method == dda::SolverMethod::open_close;
  return iterates ? system_.counters.unconverged_steps : 0;
}

bool DischargeSimulation::knows(core::Remedy remedy) const {
  switch (remedy) {
    case core::Remedy::halve_time_step:
      return true;
    case core::Remedy::tighten_tolerance:  // of the sweeps
      return plan_.solver.method == dda::SolverMethod::impulse;
    case core::Remedy::raise_penalty:  // a stored filling belongs to its own penalty
      return plan_.filling != DischargePlan::Filling::stored;
  }
  return false;
}

core::SettingChange DischargeSimulation::apply(core::Remedy remedy) {
  switch (remedy) {
    case core::Remedy::halve_time_step: {
      const double before = plan_.time_step;
      plan_.time_step *= 0.5;
      plan_.filling_time_step *= 0.5;
      system_.time_step *= 0.5;
      phase_steps_ *= 2;
      return {"discharge.time_step_s", before, plan_.time_step};  // of the filling as well
    }
    case core::Remedy::tighten_tolerance: {
      const double before = plan_.solver.tolerance;
      plan_.solver.tolerance *= kToleranceFactor;
      plan_.filling_tolerance *= kToleranceFactor;
      choose_solver();
      return {"discharge.solver.tolerance", before, plan_.solver.tolerance};
    }
    case core::Remedy::raise_penalty: {
      const double before = plan_.contact.stiffness / plan_.axial_depth;
      plan_.contact.stiffness *= kPenaltyFactor;
      plan_.filling_stiffness *= kPenaltyFactor;
      system_.contact.stiffness *= kPenaltyFactor;
      return {"discharge.penalty.stiffness_n_per_m", before, kPenaltyFactor * before};
    }
  }
  return {};
}

}  // namespace granary::scene
