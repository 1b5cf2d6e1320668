#include "worker/core/blocking.h"

#include <cmath>
#include <numeric>
#include <vector>

#include "worker/core/student_t.h"

namespace granary::core {
namespace {

double mean_of(std::span<const double> x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

double standard_error(std::span<const double> x) {
  const double mean = mean_of(x);
  double sum = 0;
  for (const double value : x) sum += (value - mean) * (value - mean);
  const auto count = static_cast<double>(x.size());
  return std::sqrt(sum / (count * (count - 1)));
}

std::vector<double> pair_means(std::span<const double> x) {
  std::vector<double> halved(x.size() / 2);
  for (std::size_t k = 0; k < halved.size(); ++k) halved[k] = 0.5 * (x[2 * k] + x[2 * k + 1]);
  return halved;
}

}  // namespace

MeanWithError blocked_mean(std::span<const double> samples) {
  MeanWithError result;
  if (samples.empty()) return result;
  result.mean = mean_of(samples);
  std::vector<double> level(samples.begin(), samples.end());
  while (level.size() >= kMinBlocks) {
    const double half_width = student_t_quantile(0.95, static_cast<unsigned>(level.size() - 1)) * standard_error(level);
    if (!result.half_width || half_width > *result.half_width) {
      result.half_width = half_width;
      result.blocks = level.size();
    }
    level = pair_means(level);
  }
  return result;
}

std::optional<std::size_t> steady_from(std::span<const double> samples) {
  constexpr std::size_t kBatch = 5;
  const std::size_t batch_count = samples.size() / kBatch;
  if (batch_count < 4) return std::nullopt;
  std::vector<double> batches(batch_count);
  for (std::size_t k = 0; k < batch_count; ++k) {
    batches[k] = mean_of(samples.subspan(k * kBatch, kBatch));
  }
  const std::size_t last_cut = batch_count / 2;
  std::size_t best = 0;
  double best_error = 0;
  for (std::size_t cut = 0; cut <= last_cut; ++cut) {
    const double error = standard_error(std::span<const double>(batches).subspan(cut));
    if (cut == 0 || error < best_error) {
      best = cut;
      best_error = error;
    }
  }
  if (best == last_cut) return std::nullopt;
  return best * kBatch;
}

}  // namespace granary::core
