#include "worker/dem/lattice_feed.h"

#include <algorithm>
#include <cmath>

#include "worker/core/random.h"

namespace granary::dem {
namespace {

// A touching lattice that just fits must not lose a row to rounding.
constexpr double kFit = 1 + 1e-9;

int rows_in(double length, double diameter, double spacing) {
  if (length * kFit < diameter) return 0;
  return 1 + static_cast<int>(std::floor((length * kFit - diameter) / spacing));
}

enum Stream : std::uint64_t { kClassStream = 1, kJitterStream = 2, kSpinStream = 3 };

}  // namespace

LatticeFeed::LatticeFeed(const LatticeFeedSetup& setup) : setup_(setup) {
  double radius = 0;
  for (const GrainClass& grain_class : setup.classes) radius = std::max(radius, grain_class.radius);
  const double diameter = 2 * radius;
  constant_ = 2 * diameter / std::sqrt(3.0);
  const int columns = rows_in(setup.width, diameter, constant_);
  const double margin = 0.5 * (setup.width - diameter - (columns - 1) * constant_);
  corner_ = sites(setup, diameter, margin, 0);
  centred_ = sites(setup, diameter, margin + 0.5 * constant_, 0.5 * constant_);
  double grains_per_mass = 0;
  for (std::size_t k = 0; k < setup.classes.size(); ++k) {
    grains_per_mass += setup.mass_fractions[k] / setup.classes[k].mass();
    cumulative_number_.push_back(grains_per_mass);
  }
  for (double& value : cumulative_number_) value /= grains_per_mass;
  const double mass_per_length =
      static_cast<double>(grains_per_period()) / (grains_per_mass * constant_);
  speed_ = setup.mass_flow / mass_per_length;
}

// A square lattice of touching-bcc spacing whose first grain touches the given offsets.
std::vector<LatticeFeed::Site> LatticeFeed::sites(const LatticeFeedSetup& setup, double diameter,
                                                  double side_offset, double floor_offset) const {
  std::vector<Site> found;
  const int levels = rows_in(setup.sluice_height - floor_offset, diameter, constant_);
  const int columns = rows_in(setup.width - side_offset, diameter, constant_);
  for (int level = 0; level < levels; ++level) {
    for (int column = 0; column < columns; ++column) {
      found.push_back({side_offset + 0.5 * diameter + column * constant_,
                       floor_offset + 0.5 * diameter + level * constant_});
    }
  }
  return found;
}

std::uint8_t LatticeFeed::draw_class(std::uint64_t grain) const {
  const double draw = core::random_uniform(setup_.seed, kClassStream, grain);
  const auto found = std::upper_bound(cumulative_number_.begin(), cumulative_number_.end(), draw);
  const auto last = cumulative_number_.size() - 1;
  return static_cast<std::uint8_t>(
      std::min<std::size_t>(static_cast<std::size_t>(found - cumulative_number_.begin()), last));
}

// Uniform in the cube [-1, 1)^3.
core::Vec3 LatticeFeed::random_vector(std::uint64_t stream, std::uint64_t grain) const {
  const auto coordinate = [&](std::uint64_t axis) {
    return 2 * core::random_uniform(setup_.seed, stream, 3 * grain + axis) - 1;
  };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

std::vector<Grain> LatticeFeed::layer(std::int64_t layer, double time) const {
  const std::vector<Site>& sites = layer % 2 == 0 ? corner_ : centred_;
  const double x = speed_ * (time - arrival_time(layer));
  std::vector<Grain> grains;
  for (std::size_t k = 0; k < sites.size(); ++k) {
    const std::uint64_t counter = static_cast<std::uint64_t>(layer) * corner_.size() + k;
    Grain grain;
    grain.grain_class = draw_class(counter);
    const GrainClass& grain_class = setup_.classes[grain.grain_class];
    grain.position =
        core::Vec3{x, sites[k].y, sites[k].z} +
        random_vector(kJitterStream, counter) * (setup_.jitter * 2 * grain_class.radius);
    grain.velocity = {speed_, 0, 0};
    grain.spin = setup_.spin + random_vector(kSpinStream, counter) *
                                   (setup_.spin_noise * speed_ / grain_class.radius);
    grain.carried = true;
    grains.push_back(grain);
  }
  return grains;
}

}  // namespace granary::dem
