#include "worker/core/student_t.h"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/core/random.h"

namespace granary::core {
namespace {

// Abramowitz & Stegun, table 26.10 (two-sided 95 % and 99 %): printed to three decimals.
TEST(StudentT, quantiles_are_those_of_the_table) {
  const struct {
    unsigned degrees;
    double t95, t99;
  } rows[] = {{1, 12.706, 63.657}, {2, 4.303, 9.925},  {3, 3.182, 5.841},  {4, 2.776, 4.604},
              {5, 2.571, 4.032},   {9, 2.262, 3.250},  {10, 2.228, 3.169}, {19, 2.093, 2.861},
              {30, 2.042, 2.750},  {120, 1.980, 2.617}};
  for (const auto& row : rows) {
    EXPECT_NEAR(student_t_quantile(0.95, row.degrees), row.t95, 5e-4) << row.degrees;
    EXPECT_NEAR(student_t_quantile(0.99, row.degrees), row.t99, 5e-4) << row.degrees;
  }
}

// Closed forms of the distribution for one and two degrees of freedom.
TEST(StudentT, matches_the_closed_forms) {
  for (const double t : {0.1, 1.0, 3.0, 40.0}) {
    EXPECT_NEAR(student_t_two_sided(t, 1), 2 / M_PI * std::atan(t), 1e-14);
    EXPECT_NEAR(student_t_two_sided(t, 2), t / std::sqrt(2 + t * t), 1e-14);
  }
}

// The normal distribution is the limit; the difference falls like t^3 / (4 degrees).
TEST(StudentT, approaches_the_normal_distribution) {
  EXPECT_NEAR(student_t_quantile(0.95, 1000), 1.959964 + (std::pow(1.96, 3) + 1.96) / 4000, 1e-5);
}

// Of intervals around means of 4 normal numbers, exactly 95 % hold the true mean 0. 4000 draws: a
// binomial standard deviation of 0.345 %; the bounds are three of them.
TEST(MeanInterval, covers_the_true_mean_as_often_as_it_says) {
  const auto normal = [](std::uint64_t draw, std::uint64_t i) {  // Box and Muller
    return std::sqrt(-2 * std::log(1 - random_uniform(1, draw, 2 * i))) *
           std::cos(2 * M_PI * random_uniform(1, draw, 2 * i + 1));
  };
  int covered = 0;
  constexpr int kDraws = 4000;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    double samples[4];
    for (std::uint64_t i = 0; i < 4; ++i) samples[i] = normal(draw, i);
    const auto interval = mean_with_interval(samples);
    if (std::abs(interval->mean) <= interval->half_width) ++covered;
  }
  EXPECT_NEAR(covered, 0.95 * kDraws, 3 * 0.00345 * kDraws);
}

TEST(MeanInterval, of_two_samples_is_known_by_hand) {
  const double samples[] = {1, 3};  // mean 2, standard error 1, t = 12.706
  const auto interval = mean_with_interval(samples);
  EXPECT_DOUBLE_EQ(interval->mean, 2);
  EXPECT_NEAR(interval->half_width, 12.7062, 1e-4);
  EXPECT_FALSE(mean_with_interval(std::span(samples, 1)));
}

}  // namespace
}  // namespace granary::core
