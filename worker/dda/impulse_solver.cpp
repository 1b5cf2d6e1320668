#include "worker/dda/impulse_solver.h"

#include <algorithm>

#include "worker/dda/narrow_phase.h"

namespace granary::dda {
namespace {

void keep_rolling(const ActiveContacts& contacts, double time_step, CandidateList& list) {
  std::fill(list.rolling_force.begin(), list.rolling_force.end(), 0.0);
  for (std::size_t k = 0; k < contacts.size; ++k)
    if (contacts.slot[k] >= 0)
      list.rolling_force[static_cast<std::size_t>(contacts.slot[k])] =
          contacts.impulse_r[k] / time_step;
}

void keep_forces_of(const ActiveContacts& contacts, double time_step, CandidateList& list) {
  std::fill(list.normal_force.begin(), list.normal_force.end(), 0.0);
  std::fill(list.tangential_force.begin(), list.tangential_force.end(), 0.0);
  for (std::size_t k = 0; k < contacts.size; ++k) {
    if (contacts.slot[k] < 0) continue;
    const auto slot = static_cast<std::size_t>(contacts.slot[k]);
    list.normal_force[slot] = contacts.impulse_n[k] / time_step;
    list.tangential_force[slot] = contacts.impulse_t[k] / time_step;
  }
}

}  // namespace

void solve_impulses(System& system) {
  DiskMotion* motion = system.disks.motion.data();
  const ContactKernels& run = kernels().laws(system.contact.effects);
  ActiveContacts& pairs = system.pair_contacts;
  ActiveContacts& walls = system.wall_contacts;
  const ContactArrays pair_arrays = arrays_of(pairs), wall_arrays = arrays_of(walls);
  const ContactTerms of_pairs = pair_terms(system), of_walls = wall_terms(system);
  run.apply_impulses(pair_arrays, pairs.size, of_pairs.spin_factor, motion);
  run.apply_impulses(wall_arrays, walls.size, of_walls.spin_factor, motion);

  const double tolerance2 = system.solver.tolerance * system.solver.tolerance;
  SweepSums sums;
  EffectCounts evaluated;
  std::uint32_t sweeps = 0;
  do {
    sums = {};
    run.sweep(pair_arrays, pairs.size, of_pairs, motion, &sums);
    run.sweep(wall_arrays, walls.size, of_walls, motion, &sums);
    evaluated.add(sums.evaluated);
    ++sweeps;
  } while (sums.change > tolerance2 * sums.total && sweeps < system.solver.max_sweeps);
  system.counters.effects.add(evaluated);
  system.report.sweeps = sweeps;
  system.counters.sweeps += sweeps;
  system.counters.contact_updates += sweeps * (pairs.size + walls.size);
  system.report.converged = !(sums.change > tolerance2 * sums.total);
  if (!system.report.converged) ++system.counters.unconverged_steps;
}

void keep_forces(System& system) {
  keep_forces_of(system.pair_contacts, pair_terms(system).small_step, system.lists.pairs);
  keep_forces_of(system.wall_contacts, wall_terms(system).small_step, system.lists.walls);
  if (!system.contact.effects.rolling) return;
  keep_rolling(system.pair_contacts, pair_terms(system).small_step, system.lists.pairs);
  keep_rolling(system.wall_contacts, wall_terms(system).small_step, system.lists.walls);
}

}  // namespace granary::dda
