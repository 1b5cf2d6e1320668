#include "worker/core/blocking.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "worker/core/random.h"

namespace granary::core {
namespace {

// Gaussian by Box-Muller from the counter-based generator.
double gaussian(std::uint64_t stream, std::uint64_t counter) {
  const double radius = std::sqrt(-2 * std::log(1 - random_uniform(7, stream, 2 * counter)));
  return radius * std::cos(2 * M_PI * random_uniform(7, stream, 2 * counter + 1));
}

// First-order autoregression with mean 0 and correlation time about 1 / (1 - memory).
std::vector<double> correlated_record(std::uint64_t stream, std::size_t length, double memory) {
  std::vector<double> record(length);
  double value = gaussian(stream, 0) / std::sqrt(1 - memory * memory);
  for (std::size_t k = 0; k < length; ++k) {
    value = memory * value + gaussian(stream, k + 1);
    record[k] = value;
  }
  return record;
}

int covered_of_200(std::size_t length, double memory) {
  int covered = 0;
  for (std::uint64_t stream = 0; stream < 200; ++stream) {
    const MeanWithError mean = blocked_mean(correlated_record(stream, length, memory));
    if (std::abs(mean.mean) <= mean.half_width.value()) ++covered;
  }
  return covered;
}

// 95 % nominal, at least 90 % required: of 200 trials at most 20 may miss.
TEST(Blocking, interval_covers_the_true_mean_of_independent_samples) {
  EXPECT_GE(covered_of_200(400, 0), 180);
}

TEST(Blocking, interval_covers_the_true_mean_of_correlated_samples) {
  EXPECT_GE(covered_of_200(400, 0.7), 180);
}

TEST(Blocking, is_not_absurdly_wide) {
  double sum = 0;
  for (std::uint64_t stream = 0; stream < 50; ++stream) {
    sum += *blocked_mean(correlated_record(stream, 400, 0)).half_width;
  }
  EXPECT_LT(sum / 50, 2.5 * 1.96 / std::sqrt(400.0));
}

TEST(Blocking, short_records_have_no_interval) {
  const std::vector<double> record = {1, 2, 3};
  const MeanWithError mean = blocked_mean(record);
  EXPECT_DOUBLE_EQ(mean.mean, 2);
  EXPECT_FALSE(mean.half_width.has_value());
}

TEST(Blocking, steady_part_begins_where_the_transient_ends) {
  std::vector<double> record = correlated_record(3, 400, 0.3);
  for (std::size_t k = 0; k < 100; ++k) record[k] += 30 * (1 - static_cast<double>(k) / 100);
  const auto first = steady_from(record);
  ASSERT_TRUE(first.has_value());
  EXPECT_GE(*first, 80U);
  EXPECT_LE(*first, 120U);
}

TEST(Blocking, a_trend_has_no_steady_part) {
  std::vector<double> record(200);
  for (std::size_t k = 0; k < 200; ++k) record[k] = static_cast<double>(k);
  EXPECT_FALSE(steady_from(record).has_value());
}

}  // namespace
}  // namespace granary::core
