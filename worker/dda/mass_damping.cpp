#include "worker/dda/mass_damping.h"

#include <cmath>

namespace granary::dda {

void damp_disks(System& system) {
  const double kept = std::exp(-system.damping_rate * system.time_step);
  double energy = 0, lost_by_landed = 0;
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    DiskMotion& v = system.disks.motion[k];
    const double lost = 0.5 * system.mass[k] * (1 - kept * kept) *
                        (v.vx * v.vx + v.vy * v.vy + 0.5 * v.surface_speed * v.surface_speed);
    energy += lost;
    if (system.disks.landed[k]) lost_by_landed += lost;
    v.vx *= kept;
    v.vy *= kept;
    v.surface_speed *= kept;
  }
  system.ledger.kinetic_j -= energy;
  system.ledger[core::EnergyChannel::normal_damping] += energy;
  system.ledger.throughput_j += energy;
  system.report.kinetic_energy -= energy - lost_by_landed;
}

}  // namespace granary::dda
