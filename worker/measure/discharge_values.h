// f1..f4 and the landing values of a discharge (PHYSICS section E 5, 6) from plain positions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace granary::measure {

struct FlyingDisk {
  double x = 0, y = 0;  // m, origin at the pulley centre
  double mass = 0;      // kg
};

struct FlightValues {
  double centre_x = 0;  // f1 [m]: mass centroid of the flying disks
  double centre_y = 0;  // m
  double distance = 0;  // f2 [m]: of the centroid from the pulley centre
  double spread = 0;    // f4 [m]: smallest radius round the centroid that holds 80 % of the disks
};

// nullopt when fewer than 5 % of `initial_count` disks fly: no number is better than a random one.
std::optional<FlightValues> flight_values(std::span<const FlyingDisk> flying,
                                          std::size_t initial_count);

struct LandingValues {
  double mean_x = 0;      // f1L [m], weighted by mass
  double half_width = 0;  // f4L [m]: holds 80 % of the landed disks
};

// Disks as they crossed the landing level (y is not used).
std::optional<LandingValues> landing_values(std::span<const FlyingDisk> landed,
                                            std::size_t initial_count);

// Angle [deg] at which `share` (0..1) of the disks has left, from samples of the remaining count at
// ascending angles; linear between them; nullopt if that many never leave.
std::optional<double> angle_of_share_left(std::span<const double> angle_deg,
                                          std::span<const double> remaining_count, double share);

// Linear interpolation of samples at ascending abscissae, constant beyond the ends.
double interpolate(std::span<const double> abscissa, std::span<const double> value, double at);

}  // namespace granary::measure
