#include "worker/measure/discharge_values.h"

#include <algorithm>
#include <cmath>

namespace granary::measure {
namespace {

constexpr double kLeastFlyingShare = 0.05;
constexpr double kHeldShare = 0.8;

// Smallest bound that holds ceil(0.8 n) of the distances.
double bound_of_share(std::vector<double> distance) {
  const auto held =
      static_cast<std::size_t>(std::ceil(kHeldShare * static_cast<double>(distance.size()) - 1e-9));
  const auto last = distance.begin() + static_cast<std::ptrdiff_t>(held - 1);
  std::nth_element(distance.begin(), last, distance.end());
  return *last;
}

bool too_few(std::size_t count, std::size_t initial_count) {
  return count == 0 ||
         static_cast<double>(count) < kLeastFlyingShare * static_cast<double>(initial_count);
}

}  // namespace

std::optional<FlightValues> flight_values(std::span<const FlyingDisk> flying,
                                          std::size_t initial_count) {
  if (too_few(flying.size(), initial_count)) return {};
  double mass = 0, x = 0, y = 0;
  for (const FlyingDisk& disk : flying) {
    mass += disk.mass;
    x += disk.mass * disk.x;
    y += disk.mass * disk.y;
  }
  FlightValues values{x / mass, y / mass, 0, 0};
  values.distance = std::hypot(values.centre_x, values.centre_y);
  std::vector<double> distance;
  for (const FlyingDisk& disk : flying)
    distance.push_back(std::hypot(disk.x - values.centre_x, disk.y - values.centre_y));
  values.spread = bound_of_share(std::move(distance));
  return values;
}

std::optional<LandingValues> landing_values(std::span<const FlyingDisk> landed,
                                            std::size_t initial_count) {
  if (too_few(landed.size(), initial_count)) return {};
  double mass = 0, x = 0;
  for (const FlyingDisk& disk : landed) {
    mass += disk.mass;
    x += disk.mass * disk.x;
  }
  LandingValues values{x / mass, 0};
  std::vector<double> distance;
  for (const FlyingDisk& disk : landed) distance.push_back(std::abs(disk.x - values.mean_x));
  values.half_width = bound_of_share(std::move(distance));
  return values;
}

std::optional<double> angle_of_share_left(std::span<const double> angle_deg,
                                          std::span<const double> remaining_count, double share) {
  if (remaining_count.empty()) return {};
  const double level = (1 - share) * remaining_count[0];
  for (std::size_t k = 1; k < remaining_count.size(); ++k) {
    if (remaining_count[k] > level) continue;
    const double drop = remaining_count[k - 1] - remaining_count[k];
    const double part = drop > 0 ? (remaining_count[k - 1] - level) / drop : 0;
    return angle_deg[k - 1] + part * (angle_deg[k] - angle_deg[k - 1]);
  }
  return {};
}

double interpolate(std::span<const double> abscissa, std::span<const double> value, double at) {
  const auto above = std::upper_bound(abscissa.begin(), abscissa.end(), at);
  if (above == abscissa.begin()) return value.front();
  if (above == abscissa.end()) return value.back();
  const auto k = static_cast<std::size_t>(above - abscissa.begin());
  const double part = (at - abscissa[k - 1]) / (abscissa[k] - abscissa[k - 1]);
  return value[k - 1] + part * (value[k] - value[k - 1]);
}

}  // namespace granary::measure
