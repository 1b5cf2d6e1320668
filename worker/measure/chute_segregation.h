// Segregation index of a mixture, along the chute (bins of 30 mm) and across it (bins of 5 mm):
// spread of the mass fraction of the first class between bins, against the spread when fully
// unmixed: I = sqrt(sum w_b (p_b - p)^2 / (p (1 - p))), w_b = share of the mass in bin b, fractions
// from time sums (Danckwerts's intensity of segregation). 0 = mixed, 1 = separated.
#pragma once

#include <vector>

#include "worker/core/simulation.h"
#include "worker/dem/grains.h"

namespace granary::measure {

class ChuteSegregation {
 public:
  static constexpr double kBinAlong = 0.03;    // m
  static constexpr double kBinAcross = 0.005;  // m

  ChuteSegregation(double length, double width);

  void accumulate(const dem::GrainTable& grains);

  // Error: jackknife over ten blocks of frames; absent below ten frames.
  std::vector<core::ObservedValue> values() const;

  void save(core::State& state) const;
  void load(const core::State& state);

 private:
  struct Mass {
    double all, first_class;
  };
  double index_over(std::size_t first_bin, std::size_t end_bin, std::size_t left_out_from,
                    std::size_t left_out_to) const;
  core::ObservedValue value(const char* name, std::size_t first_bin, std::size_t end_bin) const;

  std::size_t along_;
  std::size_t across_;
  double length_;
  double width_;
  std::vector<double> masses_;  // [frame][bin][all, first class], bins along then across
  std::size_t frames_ = 0;
};

}  // namespace granary::measure
