#include "worker/dda/small_steps.h"

#include <algorithm>
#include <cmath>

#include "worker/core/books.h"
#include "worker/dda/narrow_phase.h"
#include "worker/dda/step_energy.h"

namespace granary::dda {
namespace {

using core::EnergyChannel;

void start_disks(System& system, double small_step) {
  const double fall = system.gravity * small_step;
  system.shift.resize(system.disks.count() + 1);
  system.touched_index.clear();
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    if (!system.touched[k]) continue;
    system.touched_index.push_back(static_cast<std::uint32_t>(k));
    system.disks.motion[k].vy -= fall;
    system.shift[k] = {};
  }
  system.shift[system.disks.count()] = {};
}

// Both lists of one step, with their terms and sums.
struct SmallSteps {
  System& system;
  const ContactKernels& run = kernels().laws(system.contact.effects);
  ContactTerms of_pairs = pair_terms(system), of_walls = wall_terms(system);
  ContactArrays pairs = arrays_of(system.pair_contacts), walls = arrays_of(system.wall_contacts);
  std::size_t pair_count = system.pair_contacts.size, wall_count = system.wall_contacts.size;

  void sweep(const SmallStep& small) {
    SmallStepSums& of_pair = system.pair_sums;
    SmallStepSums& of_wall = system.wall_sums;
    of_pair.change = of_pair.total = of_wall.change = of_wall.total = 0;
    run.small_sweep_pairs(pairs, pair_count, of_pairs, small, system.shift.data(),
                          system.disks.motion.data(), system.motion_before.data(), &of_pair);
    run.small_sweep_walls(walls, wall_count, of_walls, small, system.shift.data(),
                          system.disks.motion.data(), system.motion_before.data(), &of_wall);
  }
  bool converged() const {
    const double tolerance = system.solver.tolerance;
    return system.pair_sums.change + system.wall_sums.change <=
           tolerance * tolerance * (system.pair_sums.total + system.wall_sums.total);
  }
  void warm_start() {
    run.apply_impulses(pairs, pair_count, of_pairs.spin_factor, system.disks.motion.data());
    run.apply_impulses(walls, wall_count, of_walls.spin_factor, system.disks.motion.data());
  }
};

// Springs at the start of a step, as the step sees them.
double elastic_at_start(const ContactTerms& terms, const ContactSums& contacts) {
  return 0.5 * terms.stiffness * contacts.overlap2_start + contacts.stored2 / (2 * terms.stiffness);
}

// Channels of one list; returns the elastic energy at the end of the step. The integrator's share
// is what the impulses did on the disks less what the laws dissipate and what the springs keep.
double book_list(const ContactTerms& terms, const SmallStepSums& sums, const ContactSums& contacts,
                 core::EnergyLedger& ledger) {
  const double per_step = 1 / terms.small_step;
  const double elastic_start = elastic_at_start(terms, contacts);
  const double elastic_end =
      0.5 * terms.stiffness * contacts.overlap2 + 0.5 * terms.compliance * contacts.stick2;
  const double cohesion = sums.cohesion.total() * per_step, rolling = sums.rolling.total();
  const double by_springs = sums.damping.total() * per_step;
  const double by_sliding = sums.friction.total() * per_step;
  const double integrator = sums.work.total() * per_step - by_springs - by_sliding - cohesion -
                            (elastic_end - elastic_start);
  const double damping = by_springs + sums.collision_damping.total();
  const double friction = by_sliding + sums.collision_friction.total();
  const double wall_work = sums.wall_work.total();
  ledger[EnergyChannel::cohesion] += cohesion;
  ledger[EnergyChannel::rolling] += rolling;
  ledger[EnergyChannel::integrator] += integrator;
  ledger[EnergyChannel::friction] += friction;
  ledger[EnergyChannel::normal_damping] += damping;
  ledger[EnergyChannel::wall_work] += wall_work;
  ledger.throughput_j += std::abs(integrator) + std::abs(friction) + std::abs(damping) +
                         std::abs(wall_work) + std::abs(cohesion) + std::abs(rolling);
  return elastic_end;
}

}  // namespace

void solve_small_steps(System& system) {
  SmallSteps steps{system};
  const double h = steps.of_pairs.small_step;
  const auto count = static_cast<std::uint32_t>(std::lround(system.time_step / h));
  const std::uint32_t most_sweeps = std::max(1u, system.solver.max_sweeps / count);
  start_disks(system, h);
  steps.warm_start();
  system.pair_sums = system.wall_sums = {};
  system.kinetic_dissipation = 0;
  std::uint32_t sweeps = 0;
  bool all_converged = true;
  for (std::uint32_t s = 0; s < count; ++s) {
    SmallStep small{.elapsed = s * h, .first_sweep = true, .books = s > 0};
    std::uint32_t done = 0;
    do {
      steps.sweep(small);
      small.first_sweep = false;
      ++done;
    } while (!steps.converged() && done < most_sweeps);
    all_converged = all_converged && steps.converged();
    sweeps += done;
    system.kinetic_dissipation += kernels().advance_disks(
        system.touched_index.data(), system.touched_index.size(), h, system.mass.data(),
        system.disks.motion.data(), system.motion_before.data(), system.shift.data());
  }
  // The last advance has begun a step that is not taken.
  for (const std::uint32_t k : system.touched_index)
    system.disks.motion[k] = system.motion_before[k];
  system.report.sweeps = sweeps;
  system.counters.sweeps += sweeps;
  system.counters.contact_updates += sweeps * (steps.pair_count + steps.wall_count);
  system.report.converged = all_converged;
  if (!all_converged) ++system.counters.unconverged_steps;
}

void close_small_steps(System& system) {
  SmallSteps steps{system};
  const SmallStep end{.elapsed = system.time_step, .first_sweep = true, .books = true};
  ContactSums pairs, walls;
  steps.run.close_pairs(steps.pairs, steps.pair_count, steps.of_pairs, end, system.shift.data(),
                        &system.pair_sums, &pairs);
  steps.run.close_walls(steps.walls, steps.wall_count, steps.of_walls, end, system.shift.data(),
                        &system.wall_sums, &walls);
  system.report.worst_overlap = std::max(pairs.worst_overlap, walls.worst_overlap);
  system.counters.effects.add(system.pair_sums.evaluated);
  system.counters.effects.add(system.wall_sums.evaluated);
  core::EnergyLedger& ledger = system.ledger;
  book_relinearised(
      system, elastic_at_start(steps.of_pairs, pairs) + elastic_at_start(steps.of_walls, walls));
  ledger.elastic_j = book_list(steps.of_pairs, system.pair_sums, pairs, ledger) +
                     book_list(steps.of_walls, system.wall_sums, walls, ledger);
  ledger[EnergyChannel::integrator] += system.kinetic_dissipation;
  ledger.throughput_j += system.kinetic_dissipation;
}

void integrate_small_steps(System& system) {
  const double dt = system.time_step, gravity = system.gravity;
  double kinetic = 0, landed_kinetic = 0, fall_work = 0;
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    DiskPose& pose = system.disks.pose[k];
    DiskMotion& v = system.disks.motion[k];
    const double height = pose.y;
    if (system.touched[k]) {
      const DiskShift& moved = system.shift[k];
      pose.x += moved.x;
      pose.y += moved.y;
      pose.angle += moved.surface / pose.radius;
    } else {
      pose.x += dt * v.vx;
      pose.y += dt * (v.vy - 0.5 * gravity * dt);
      pose.angle += dt * v.surface_speed / pose.radius;
      v.vy -= gravity * dt;
    }
    const double energy = 0.5 * system.mass[k] *
                          (v.vx * v.vx + v.vy * v.vy + 0.5 * v.surface_speed * v.surface_speed);
    (system.disks.landed[k] ? landed_kinetic : kinetic) += energy;
    if constexpr (core::kBooks) fall_work += (height - pose.y) * system.mass[k];
  }
  core::EnergyLedger& ledger = system.ledger;
  ledger.kinetic_j = kinetic + landed_kinetic;
  ledger.potential_j -= gravity * fall_work;
  ledger.throughput_j += std::abs(gravity * fall_work);
  system.report.kinetic_energy = kinetic;
}

}  // namespace granary::dda
