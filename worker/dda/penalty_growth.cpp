#include "worker/dda/penalty_growth.h"

#include <algorithm>
#include <cmath>

#include "worker/dda/narrow_phase.h"

namespace granary::dda {
namespace {

using core::EnergyChannel;

constexpr double kLargestKappa = 1e3;       // K dt^2 / m
constexpr double kLargestStiffness = 1e12;  // N/m; beyond it overlaps drown in rounding

// Largest overlap / radius of contacts that carried force at both ends of the step.
double worst_overlap(const System& system, const ActiveContacts& contacts) {
  const auto radius_of = [&](std::int32_t disk) {
    const double radius = system.disks.pose[static_cast<std::size_t>(disk)].radius;
    return radius > 0 ? radius : 1e6;  // the resting record stands for walls
  };
  const double span = pair_terms(system).small_step;  // impulses belong to it
  double worst = 0;
  for (std::size_t k = 0; k < contacts.size; ++k) {
    if (contacts.slot[k] < 0 || contacts.impulse_n[k] <= 0 || contacts.gap_start[k] >= 0) continue;
    const double overlap = contacts.impulse_n[k] / (span * system.contact.stiffness);
    const double radius = std::min(radius_of(contacts.first[k]), radius_of(contacts.second[k]));
    worst = std::max(worst, overlap / radius);
  }
  return worst;
}

}  // namespace

double penalty_cap(const System& system) {
  double largest_inverse_mass = 0;
  for (const DiskMotion& v : system.disks.motion)
    largest_inverse_mass = std::max(largest_inverse_mass, v.inverse_mass);
  const double dt = system.time_step;
  if (largest_inverse_mass == 0) return kLargestStiffness;
  return std::min(kLargestStiffness, kLargestKappa / (largest_inverse_mass * dt * dt));
}

void change_penalty(System& system, double stiffness) {
  const double before = system.contact.stiffness;
  double normal = 0, tangential = 0;  // sums of squared forces
  for (CandidateList* list : {&system.lists.pairs, &system.lists.walls})
    for (std::size_t s = 0; s < list->size(); ++s) {
      if (list->normal_force[s] < 0) continue;  // a cohesive pull has no overlap
      normal += list->normal_force[s] * list->normal_force[s];
      tangential += list->tangential_force[s] * list->tangential_force[s];
      list->normal_force[s] *= stiffness / before;
    }
  const double added = 0.5 * (stiffness - before) * normal / (before * before) +
                       0.5 * (1 / stiffness - 1 / before) * tangential;
  system.contact.stiffness = stiffness;
  system.ledger.elastic_j += added;
  system.ledger[EnergyChannel::penalty_change] -= added;
  system.ledger.throughput_j += std::abs(added);
}

void grow_penalty(System& system) {
  if (system.penalty.factor <= 1) return;
  const double worst = std::max(worst_overlap(system, system.pair_contacts),
                                worst_overlap(system, system.wall_contacts));
  if (worst <= system.penalty.tolerance) return;
  const double grown =
      std::min(system.contact.stiffness * system.penalty.factor, penalty_cap(system));
  if (grown <= system.contact.stiffness) return;
  change_penalty(system, grown);
  ++system.counters.penalty_growths;
}

}  // namespace granary::dda
