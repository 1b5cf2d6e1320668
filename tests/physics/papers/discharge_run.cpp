#include "tests/physics/papers/discharge_run.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "worker/dda/walls.h"
#include "worker/scene/discharge_simulation.h"

namespace granary::tests {
namespace {

using scene::DischargePhase;
using scene::DischargePlan;
using scene::DischargeSimulation;

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
constexpr double kHardlyPressing = 0.01;  // of the disks

// What is noted once a degree.
class Observer {
 public:
  Observer(const DischargePlan& plan, const DischargeSimulation& simulation)
      : plan_(plan), simulation_(simulation), system_(simulation.system()) {
    const std::size_t outer_count = plan.bucket->outer_wall.size() - 1;
    run_.slip_deg = run_.cg_moves_deg = kNever;
    for (std::size_t k = 0; k < system_.disks.count(); ++k) {
      start_.push_back(in_bucket_frame(k));
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t s = 0; s < outer_count; ++s)
        nearest = std::min(nearest, distance_to_segment(system_.walls.segments[s], start_.back()));
      run_.disks.push_back({kNever, system_.disks.stratum[k], nearest});
      run_.filled_mass += system_.mass[k];
    }
    start_cg_ = centroid(start_);
    outer_segments_ = static_cast<std::int32_t>(outer_count);
  }

  void note() {
    const double angle = angle_deg();
    double path = 0;
    std::vector<dda::Vec2> now;
    std::size_t inside = 0;
    for (std::size_t k = 0; k < system_.disks.count(); ++k) {
      now.push_back(in_bucket_frame(k));
      const bool in = scene::disk_in_bucket(system_, *plan_.bucket, k);
      inside += in;
      path += length(now.back() - start_[k]);
      double& left = run_.disks[k].left_deg;
      if (in) left = kNever;
      if (!in && std::isnan(left)) left = angle;
    }
    const auto count = static_cast<double>(system_.disks.count());
    if (std::isnan(run_.slip_deg) && path / count > system_.mean_radius) run_.slip_deg = angle;
    if (std::isnan(run_.cg_moves_deg) &&
        length(centroid(now) - start_cg_) > 2 * system_.mean_radius)
      run_.cg_moves_deg = angle;
    if (pressing_outer_wall() > kHardlyPressing * count) run_.off_outer_wall_deg = angle;
    run_.remaining.push_back(100 * static_cast<double>(inside) / count);
  }

  double angle_deg() const {
    return system_.time * system_.drive.rotation_rate * 180 / std::numbers::pi;
  }
  DischargeRun take() { return std::move(run_); }

 private:
  dda::Vec2 in_bucket_frame(std::size_t k) const {
    const dda::DiskPose& p = system_.disks.pose[k];
    return system_.bucket_pose(system_.time).to_body({p.x, p.y});
  }
  static dda::Vec2 centroid(const std::vector<dda::Vec2>& points) {
    dda::Vec2 sum;
    for (const dda::Vec2 p : points) sum = sum + p;
    return (1.0 / static_cast<double>(points.size())) * sum;
  }
  double pressing_outer_wall() const {
    const dda::CandidateList& walls = system_.lists.walls;
    double count = 0;
    for (std::size_t s = 0; s < walls.size(); ++s)
      count += walls.normal_force[s] > 0 && walls.second[s] < outer_segments_;
    return count;
  }

  const DischargePlan& plan_;
  const DischargeSimulation& simulation_;
  const dda::System& system_;
  std::int32_t outer_segments_ = 0;
  std::vector<dda::Vec2> start_;  // bucket coordinates
  dda::Vec2 start_cg_;
  DischargeRun run_;
};

std::uint64_t iterations_of(const dda::StepCounters& c) {
  return c.open_close_iterations > 0 ? c.open_close_iterations : c.sweeps;
}

}  // namespace

DischargeRun run_discharge(const DischargePlan& plan) {
  DischargeSimulation simulation(plan, nullptr);
  const dda::System& system = simulation.system();
  bool accepted = true;
  const auto advance = [&] {
    accepted = simulation.advance(1e9, 1).status != core::AdvanceStatus::rejected;
  };
  while (accepted && simulation.phase() != DischargePhase::rotation) advance();
  Observer observer(plan, simulation);
  const dda::StepCounters before = system.counters;
  observer.note();
  double next = 1;
  while (accepted && simulation.phase() == DischargePhase::rotation) {
    advance();
    if (observer.angle_deg() < next - 1e-9) continue;
    observer.note();
    ++next;
  }
  DischargeRun run = observer.take();
  for (const core::ObservedValue& value : simulation.observe().values)
    if (value.value) run.values[value.name] = *value.value;
  run.warnings = simulation.observe().warnings;
  run.energy_by_penalty = -system.ledger[core::EnergyChannel::penalty_change];
  run.final_stiffness = system.contact.stiffness;
  run.steps = system.counters.steps - before.steps;
  run.iterations =
      iterations_of(system.counters) -
      (system.counters.open_close_iterations > 0 ? before.open_close_iterations : before.sweeps);
  run.unconverged = system.counters.unconverged_steps - before.unconverged_steps;
  run.finished = accepted;
  return run;
}

double mean_exit_of_stratum(const DischargeRun& run, std::uint32_t stratum) {
  double sum = 0, count = 0;
  for (const DiskHistory& disk : run.disks)
    if (disk.stratum == stratum && !std::isnan(disk.left_deg)) sum += disk.left_deg, ++count;
  return sum / count;
}

ExitByPlace mean_exit_by_place(const DischargeRun& run, double share) {
  double farthest = 0, near_sum = 0, near_count = 0, far_sum = 0, far_count = 0;
  for (const DiskHistory& disk : run.disks)
    farthest = std::max(farthest, disk.distance_to_outer_wall);
  for (const DiskHistory& disk : run.disks) {
    if (std::isnan(disk.left_deg)) continue;
    const bool near = disk.distance_to_outer_wall < share * farthest;
    (near ? near_sum : far_sum) += disk.left_deg;
    (near ? near_count : far_count) += 1;
  }
  return {near_sum / near_count, far_sum / far_count};
}

Sample summarize(const std::vector<double>& values) {
  constexpr double kStudent[] = {0, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306};
  const std::size_t count = values.size();
  double mean = 0, squares = 0;
  for (const double v : values) mean += v / static_cast<double>(count);
  for (const double v : values) squares += (v - mean) * (v - mean);
  if (count < 2) return {mean, std::numeric_limits<double>::quiet_NaN()};
  const std::size_t freedom = std::min<std::size_t>(count - 1, std::size(kStudent) - 1);
  return {mean, kStudent[freedom] * std::sqrt(squares / static_cast<double>(count * (count - 1)))};
}

}  // namespace granary::tests
