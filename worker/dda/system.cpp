#include "worker/dda/system.h"

#include <algorithm>
#include <limits>

#include "worker/dda/step_energy.h"

namespace granary::dda {

std::string_view to_string(StepPhase phase) {
  constexpr std::array<std::string_view, kStepPhaseCount> names = {
      "neighbour lists", "contacts", "sweeps", "integration", "ledger"};
  return names.at(static_cast<std::size_t>(phase));
}

double mean_radius(const Disks& disks) {
  double sum = 0;
  for (std::size_t k = 0; k < disks.count(); ++k) sum += disks.pose[k].radius;
  return disks.count() > 0 ? sum / static_cast<double>(disks.count()) : 0;
}

void note_masses(System& system) {
  system.mass.resize(system.disks.count());
  double sum = 0;
  system.one_mass = system.disks.count() > 0;
  system.smallest_radius = system.lightest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < system.mass.size(); ++k) {
    sum += system.mass[k] = 1 / system.disks.motion[k].inverse_mass;
    system.lightest = std::min(system.lightest, system.mass[k]);
    system.one_mass &= system.disks.motion[k].inverse_mass == system.disks.motion[0].inverse_mass;
    system.smallest_radius = std::min(system.smallest_radius, system.disks.pose[k].radius);
  }
  system.mean_radius = mean_radius(system.disks);
  system.mean_mass = system.mass.empty() ? 0 : sum / static_cast<double>(system.mass.size());
}

void reset_contacts(System& system) {
  note_masses(system);
  system.lists = {};
  system.lists.set_skin(system.solver.skin_ratio * mean_radius(system.disks));
  system.contact_acceleration.clear();
  system.touched.assign(system.disks.count() + 1, 0);
  open_ledger(system);
}

}  // namespace granary::dda
