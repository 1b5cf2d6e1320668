// Where the energy went: every channel is integrated from its own forces, none is booked as a
// difference, so what does not add up stays visible as the remainder (PHYSICS sections A5, I).
// Sign: energy that leaves the particles' mechanical energy through a channel is positive, energy
// that enters is negative. remainder = stored_now - stored_at_start + sum of channels.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace granary::core {

enum class EnergyChannel : std::size_t {
  normal_damping,   // dashpots and restitution
  friction,
  rolling,
  wall_work,        // moving walls and belt
  frame_work,       // centrifugal work in the corotating frame
  gas,
  cohesion,
  integrator,       // exact identity of the implicit step
  penalty_change,   // 1/2 dK g^2
  inlet,
  outlet,
  count
};

constexpr std::size_t kEnergyChannelCount = static_cast<std::size_t>(EnergyChannel::count);
std::string_view to_string(EnergyChannel channel);

struct EnergyLedger {
  double kinetic_j = 0;    // stored now
  double potential_j = 0;  // gravity, any zero level
  double elastic_j = 0;
  double stored_at_start_j = 0;
  std::array<double, kEnergyChannelCount> channels_j{};
  double throughput_j = 0;  // sum of abs(all exchanges): the scale of the remainder

  double& operator[](EnergyChannel channel) { return channels_j[static_cast<std::size_t>(channel)]; }
  double operator[](EnergyChannel channel) const {
    return channels_j[static_cast<std::size_t>(channel)];
  }
  double stored_j() const { return kinetic_j + potential_j + elastic_j; }
  double remainder_j() const;
  double remainder_ratio() const;  // |remainder| / throughput; 0 when nothing happened
};

}  // namespace granary::core
