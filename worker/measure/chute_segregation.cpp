#include "worker/measure/chute_segregation.h"

#include <cmath>

#include "worker/core/student_t.h"

namespace granary::measure {
namespace {

constexpr std::size_t kJackknifeBlocks = 10;

}  // namespace

ChuteSegregation::ChuteSegregation(double length, double width)
    : along_(static_cast<std::size_t>(std::ceil(length / kBinAlong - 1e-9))),
      across_(static_cast<std::size_t>(std::ceil(width / kBinAcross - 1e-9))),
      length_(length),
      width_(width) {}

void ChuteSegregation::accumulate(const dem::GrainTable& grains) {
  const std::size_t start = masses_.size();
  masses_.resize(start + 2 * (along_ + across_));
  ++frames_;
  for (std::size_t k = 0; k < grains.size(); ++k) {
    const core::Vec3& p = grains.position[k];
    if (grains.carried[k] || p.x < 0 || p.x >= length_ || p.y < 0 || p.y >= width_) continue;
    const double mass = grains.mass[k];
    const double of_first = grains.grain_class[k] == 0 ? mass : 0;
    const auto ix = static_cast<std::size_t>(p.x / kBinAlong);
    const auto iy = along_ + static_cast<std::size_t>(p.y / kBinAcross);
    for (const std::size_t bin : {ix, iy}) {
      masses_[start + 2 * bin] += mass;
      masses_[start + 2 * bin + 1] += of_first;
    }
  }
}

double ChuteSegregation::index_over(std::size_t first_bin, std::size_t end_bin,
                                    std::size_t left_out_from, std::size_t left_out_to) const {
  const std::size_t stride = 2 * (along_ + across_);
  std::vector<Mass> sums(end_bin - first_bin);
  Mass total{};
  for (std::size_t frame = 0; frame < frames_; ++frame) {
    if (frame >= left_out_from && frame < left_out_to) continue;
    for (std::size_t bin = first_bin; bin < end_bin; ++bin) {
      const double* mass = &masses_[frame * stride + 2 * bin];
      sums[bin - first_bin].all += mass[0];
      sums[bin - first_bin].first_class += mass[1];
      total.all += mass[0];
      total.first_class += mass[1];
    }
  }
  const double mean = total.all > 0 ? total.first_class / total.all : 0;
  if (mean <= 0 || mean >= 1) return 0;
  double variance = 0;
  for (const Mass& sum : sums) {
    if (sum.all == 0) continue;
    const double deviation = sum.first_class / sum.all - mean;
    variance += sum.all / total.all * deviation * deviation;
  }
  return std::sqrt(variance / (mean * (1 - mean)));
}

core::ObservedValue ChuteSegregation::value(const char* name, std::size_t first_bin,
                                            std::size_t end_bin) const {
  core::ObservedValue value{name, "1", std::nullopt, std::nullopt, "no frame in the sampling time"};
  if (frames_ == 0) return value;
  value.value = index_over(first_bin, end_bin, 0, 0);
  value.error_basis = "too few frames for an interval";
  if (frames_ < kJackknifeBlocks) return value;
  double sum = 0;
  double squares = 0;
  for (std::size_t block = 0; block < kJackknifeBlocks; ++block) {
    const double index = index_over(first_bin, end_bin, block * frames_ / kJackknifeBlocks,
                                    (block + 1) * frames_ / kJackknifeBlocks);
    sum += index;
    squares += index * index;
  }
  const double blocks = kJackknifeBlocks;
  const double variance = (blocks - 1) / blocks * (squares - sum * sum / blocks);
  value.error = core::student_t_quantile(0.95, kJackknifeBlocks - 1) * std::sqrt(std::max(0.0, variance));
  value.error_basis = "jackknife over ten blocks of frames";
  return value;
}

std::vector<core::ObservedValue> ChuteSegregation::values() const {
  return {value("segregation_index_along", 0, along_),
          value("segregation_index_across", along_, along_ + across_)};
}

void ChuteSegregation::save(core::State& state) const {
  state.put("segregation.mass_kg", "kg", masses_);
  state.put_scalar("segregation.frames", "1", static_cast<std::uint64_t>(frames_));
}

void ChuteSegregation::load(const core::State& state) {
  masses_ = state.get<double>("segregation.mass_kg");
  frames_ = state.get_scalar<std::uint64_t>("segregation.frames");
}

}  // namespace granary::measure
