#include "worker/dda/air_drag.h"

#include <cmath>

namespace granary::dda {

double drag_rate(const StillAir& air, double diameter, double speed) {
  const double reynolds = air.density * speed * diameter / air.viscosity;
  const double stokes = 18 * air.viscosity / (air.disk_density * diameter * diameter);
  if (reynolds < 1000) return stokes * (1 + 0.15 * std::pow(reynolds, 0.687));
  return stokes * 0.44 * reynolds / 24;
}

void slow_flying_disks(System& system, const StillAir& air,
                       const std::vector<std::uint8_t>& flying) {
  double lost = 0;
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    if (!flying[k]) continue;
    DiskMotion& v = system.disks.motion[k];
    const double speed = std::hypot(v.vx, v.vy);
    const double rate = drag_rate(air, 2 * system.disks.pose[k].radius, speed);
    const double kept = std::exp(-rate * system.time_step);
    lost += (1 - kept * kept) * speed * speed / (2 * v.inverse_mass);
    v.vx *= kept;
    v.vy *= kept;
    ++system.counters.drag_evaluations;
  }
  system.ledger.kinetic_j -= lost;
  system.ledger[core::EnergyChannel::gas] += lost;
  system.ledger.throughput_j += lost;
}

}  // namespace granary::dda
