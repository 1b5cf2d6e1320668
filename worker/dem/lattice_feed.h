// The paper's inlet: a touching bcc lattice over width x sluice height, pushed in at the speed that
// gives the mass flow (PHYSICS section A6). Layers are half a lattice constant apart and alternate
// between the corner lattice (A) and the centred one (B). A layer is carried with constant velocity
// through x < 0 and set free when it reaches x = 0.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/dem/setup.h"

namespace granary::dem {

struct LatticeFeedSetup {
  double width = 0.08;           // m
  double sluice_height = 0.045;  // m
  double mass_flow = 1.6;        // kg/s
  std::vector<GrainClass> classes;
  std::vector<double> mass_fractions;  // one per class, sum 1
  core::Vec3 spin;                     // of entering grains, relative to the chute [rad/s]
  double jitter = 0;      // largest displacement from the lattice along each axis / diameter
  double spin_noise = 0;  // random surface speed of an entering grain / inlet speed
  std::uint64_t seed = 0;
};

class LatticeFeed {
 public:
  // Precondition: width and sluice height hold at least one grain of the largest class.
  explicit LatticeFeed(const LatticeFeedSetup& setup);

  std::size_t grains_per_period() const { return corner_.size() + centred_.size(); }
  std::size_t layer_size(std::int64_t layer) const {
    return layer % 2 == 0 ? corner_.size() : centred_.size();
  }
  double lattice_constant() const { return constant_; }               // m
  double speed() const { return speed_; }                             // m/s
  double layer_interval() const { return constant_ / (2 * speed_); }  // s

  // Layer k = 0, 1, ... reaches x = 0 at k layer_interval().
  double arrival_time(std::int64_t layer) const {
    return static_cast<double>(layer) * layer_interval();
  }
  // The layer as it stands at `time`; classes are drawn by mass fraction.
  std::vector<Grain> layer(std::int64_t layer, double time) const;

 private:
  struct Site {
    double y, z;
  };
  std::vector<Site> sites(const LatticeFeedSetup& setup, double diameter, double side_offset,
                          double floor_offset) const;
  std::uint8_t draw_class(std::uint64_t grain) const;
  core::Vec3 random_vector(std::uint64_t stream, std::uint64_t grain) const;

  LatticeFeedSetup setup_;
  double constant_ = 0;
  double speed_ = 0;
  std::vector<Site> corner_;
  std::vector<Site> centred_;
  std::vector<double> cumulative_number_;  // of classes, last = 1
};

}  // namespace granary::dem
