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
double elastic_at_start(const ContactTerms& terms, const ActiveContacts& contacts) {
  double overlap2 = 0, stored2 = 0;
  for (std::size_t k = 0; k < contacts.size; ++k) {
    const double side = contacts.offset_t[k], stored = contacts.stored_t[k];
    const double gap = contacts.gap_linear[k] + contacts.curvature[k] * side * side;
    if (gap < 0) overlap2 += gap * gap;
    stored2 += stored * stored;
  }
  return 0.5 * terms.stiffness * overlap2 + stored2 / (2 * terms.stiffness);
}

double elastic_at_end(const ContactTerms& terms, const ContactSums& contacts) {
  return 0.5 * terms.stiffness * contacts.overlap2 + 0.5 * terms.compliance * contacts.stick2;
}

// What the contacts did in a step [J].
struct Booked {
  double by_springs = 0;  // work on springs, dashpots and friction, all impulses together
  double damping = 0;     // of dashpots, before gaps closed, and what springs held that let go
  double friction = 0;    // of sliding, where springs were cut off at Coulomb's limit
  double cohesion = 0, rolling = 0, wall_work = 0;
  double collision_damping = 0, collision_friction = 0;
};

void add_list(const ContactTerms& terms, const SmallStepSums& sums, bool history, Booked& booked) {
  const double h = terms.small_step, sliding = sums.tangential_work.total();
  const double lost_in_springs = terms.stiffness * h * sums.spring_loss.total();
  double damping = lost_in_springs + sums.closing_work.total(), friction = -sliding;
  if (history) {
    const double stuck = sums.stick_work.total();
    damping += stuck - sliding;
    friction = -(stuck + terms.compliance * h * sums.stick_change.total());
  }
  booked.by_springs += (sums.normal_work.total() - sliding) / h;
  booked.damping += damping / h;
  booked.friction += friction / h;
  booked.cohesion += sums.cohesion.total() / h;
  booked.rolling += sums.rolling.total();
  booked.wall_work += sums.wall_work.total();
  booked.collision_damping += sums.collision_damping.total();
  booked.collision_friction += sums.collision_friction.total();
}

// The integrator's share is what the contacts took from the disks, less what their laws dissipate
// and what the springs keep: the sweeps end before the laws are met.
void write_books(const Booked& booked, double elastic_gain, core::EnergyLedger& ledger) {
  const auto write = [&](EnergyChannel channel, double energy) {
    ledger[channel] += energy;
    ledger.throughput_j += std::abs(energy);
  };
  write(EnergyChannel::integrator,
        booked.by_springs - booked.damping - booked.friction - booked.cohesion - elastic_gain);
  write(EnergyChannel::normal_damping, booked.damping + booked.collision_damping);
  write(EnergyChannel::friction, booked.friction + booked.collision_friction);
  write(EnergyChannel::cohesion, booked.cohesion);
  write(EnergyChannel::rolling, booked.rolling);
  write(EnergyChannel::wall_work, booked.wall_work);
}

void book_step(System& system, const SmallSteps& steps, double elastic) {
  core::EnergyLedger& ledger = system.ledger;
  if (system.ledger_is_new)
    start_elastic(system, elastic_at_start(steps.of_pairs, system.pair_contacts) +
                              elastic_at_start(steps.of_walls, system.wall_contacts));
  if (system.keeps_books) {
    Booked booked;
    const bool history = system.contact.effects.history;
    add_list(steps.of_pairs, system.pair_sums, history, booked);
    add_list(steps.of_walls, system.wall_sums, history, booked);
    write_books(booked, elastic - ledger.elastic_j, ledger);
    ledger[EnergyChannel::integrator] += system.kinetic_dissipation;
    ledger.throughput_j += system.kinetic_dissipation;
  }
  ledger.elastic_j = elastic;
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
    SmallStep small{
        .elapsed = s * h, .first_sweep = true, .closes = s > 0, .books = system.keeps_books};
    std::uint32_t done = 0;
    do {
      steps.sweep(small);
      small.first_sweep = false;
      ++done;
    } while (!steps.converged() && done < most_sweeps);
    all_converged = all_converged && steps.converged();
    sweeps += done;
    system.kinetic_dissipation +=
        kernels().advance_disks(system.touched_index.data(), system.touched_index.size(), h,
                                system.keeps_books, system.mass.data(), system.disks.motion.data(),
                                system.motion_before.data(), system.shift.data());
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
  const SmallStep end{.elapsed = system.time_step,
                      .first_sweep = true,
                      .closes = true,
                      .books = system.keeps_books};
  ContactSums pairs, walls;
  steps.run.close_pairs(steps.pairs, steps.pair_count, steps.of_pairs, end, system.shift.data(),
                        &system.pair_sums, &pairs);
  steps.run.close_walls(steps.walls, steps.wall_count, steps.of_walls, end, system.shift.data(),
                        &system.wall_sums, &walls);
  system.report.worst_overlap = std::max(pairs.worst_overlap, walls.worst_overlap);
  system.counters.effects.add(system.pair_sums.evaluated);
  system.counters.effects.add(system.wall_sums.evaluated);
  book_step(system, steps,
            elastic_at_end(steps.of_pairs, pairs) + elastic_at_end(steps.of_walls, walls));
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
