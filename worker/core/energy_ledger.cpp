#include "worker/core/energy_ledger.h"

#include <cmath>
#include <numeric>

namespace granary::core {

std::string_view to_string(EnergyChannel channel) {
  constexpr std::array<std::string_view, kEnergyChannelCount> names = {
      "normal_damping", "friction", "rolling",        "wall_work", "frame_work", "gas",
      "cohesion",       "integrator", "penalty_change", "inlet",     "outlet"};
  return names.at(static_cast<std::size_t>(channel));
}

double EnergyLedger::remainder_j() const {
  return stored_j() - stored_at_start_j +
         std::accumulate(channels_j.begin(), channels_j.end(), 0.0);
}

double EnergyLedger::remainder_ratio() const {
  return throughput_j > 0 ? std::abs(remainder_j()) / throughput_j : 0;
}

}  // namespace granary::core
