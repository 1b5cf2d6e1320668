#include "proto/contract/ladder.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace granary {
namespace {

// Orders outside of this are noise that looks like one.
constexpr double kLowestOrder = 0.3, kHighestOrder = 4;

// Welch-Satterthwaite; at least one.
unsigned degrees_of(const LevelMean& a, const LevelMean& b) {
  const double va = a.variance_of_mean(), vb = b.variance_of_mean();
  if (a.count < 2 || b.count < 2 || va + vb == 0) return std::max(a.count, b.count) > 1 ? 1 : 0;
  const double degrees =
      (va + vb) * (va + vb) / (va * va / (a.count - 1) + vb * vb / (b.count - 1));
  return static_cast<unsigned>(std::max(1.0, std::floor(degrees)));
}

}  // namespace

double student_t_95(unsigned degrees) {
  return boost::math::quantile(boost::math::students_t(degrees), 0.975);
}

LevelMean level_of(double mean, double half_width, unsigned count) {
  if (count < 2) return {mean, 0, count};
  return {mean, half_width * std::sqrt(count) / student_t_95(count - 1), count};
}

Difference difference(const LevelMean& a, const LevelMean& b) {
  const unsigned degrees = degrees_of(a, b);
  const double error = std::sqrt(a.variance_of_mean() + b.variance_of_mean());
  return {a.mean - b.mean, degrees > 0 ? student_t_95(degrees) * error : 0};
}

LadderVerdict judge_ladder(std::span<const LevelMean> levels, double ratio) {
  const LevelMean& finest = levels.back();
  LadderVerdict verdict;
  verdict.limit = finest.mean;
  const Difference alone = difference(finest, {finest.mean, 0, finest.count});
  verdict.limit_half_width = alone.half_width;
  if (levels.size() < 2) return verdict;
  const Difference last = difference(levels[levels.size() - 2], finest);
  // Of first order at worst: what is still to come is as large as the last difference.
  if (last.shows()) verdict.limit_half_width = std::hypot(alone.half_width, last.value);
  if (levels.size() < 3) return verdict;
  const Difference before = difference(levels[levels.size() - 3], levels[levels.size() - 2]);
  if (!last.shows() || !before.shows() || last.value * before.value <= 0) return verdict;
  const double order = std::log(before.value / last.value) / std::log(ratio);
  if (order < kLowestOrder || order > kHighestOrder) return verdict;
  const double share = 1 / (std::pow(ratio, order) - 1);  // of the last difference still to come
  verdict.order = order;
  verdict.limit = finest.mean - share * last.value;
  verdict.limit_half_width = std::hypot(alone.half_width, share * last.half_width);
  return verdict;
}

double bias_bound(const LevelMean& level, const LevelMean& finest, const LadderVerdict& verdict) {
  if (level.mean == finest.mean && level.count == finest.count) {
    if (verdict.order) return std::abs(finest.mean - verdict.limit);
    return 0;
  }
  const Difference seen = difference(level, finest);
  const double off = std::abs(level.mean - verdict.limit);
  return seen.shows() ? off : std::max(off, seen.half_width);
}

}  // namespace granary
