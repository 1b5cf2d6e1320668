#include "proto/contract/ladder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace granary {
namespace {

std::vector<LevelMean> exact(double limit, double error, double ratio, double order, int count) {
  std::vector<LevelMean> levels;
  for (int k = 0; k < count; ++k)
    levels.push_back({limit + error * std::pow(ratio, -order * k), 1e-9, 8});
  return levels;
}

TEST(Ladder, finds_order_and_limit_of_exact_levels) {
  for (const double order : {1.0, 2.0}) {
    const auto levels = exact(3, 0.4, 2, order, 4);
    const LadderVerdict verdict = judge_ladder(levels, 2);
    ASSERT_TRUE(verdict.order);
    EXPECT_NEAR(*verdict.order, order, 1e-5);
    EXPECT_NEAR(verdict.limit, 3, 1e-7);
  }
}

TEST(Ladder, says_below_noise_when_noise_hides_the_differences) {
  std::vector<LevelMean> levels = exact(3, 0.01, 2, 1, 4);
  for (LevelMean& level : levels) level.deviation = 0.1;
  const LadderVerdict verdict = judge_ladder(levels, 2);
  EXPECT_FALSE(verdict.order);
  EXPECT_EQ(verdict.limit, levels.back().mean);
  EXPECT_GT(verdict.limit_half_width, 0.05);
  // What could hide: the half-width of the difference.
  EXPECT_NEAR(bias_bound(levels[0], levels.back(), verdict),
              difference(levels[0], levels.back()).half_width, 1e-12);
}

TEST(Ladder, takes_differences_of_two_signs_for_no_order) {
  const std::vector<LevelMean> levels = {{3, 1e-6, 4}, {3.2, 1e-6, 4}, {3.1, 1e-6, 4}};
  EXPECT_FALSE(judge_ladder(levels, 2).order);
}

TEST(Ladder, level_comes_back_from_mean_and_half_width) {
  // 1, 2, 3, 4, 5: t = 2.776 for four degrees.
  const LevelMean level = level_of(3, 2.7764451 * std::sqrt(2.5 / 5), 5);
  EXPECT_NEAR(level.mean, 3, 1e-12);
  EXPECT_NEAR(level.deviation, std::sqrt(2.5), 1e-7);
}

// 2000 pairs of five normal samples with the same mean: 5 % of the intervals may miss zero, give or
// take three standard deviations of that count (1.5 %).
TEST(Ladder, differences_cover_as_often_as_they_say) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  int missed = 0;
  for (int k = 0; k < 2000; ++k) {
    LevelMean levels[2];
    for (LevelMean& level : levels) {
      double sum = 0, squares = 0;
      for (int sample = 0; sample < 5; ++sample) {
        const double value = normal(random);
        sum += value;
        squares += value * value;
      }
      level = {sum / 5, std::sqrt((squares - sum * sum / 5) / 4), 5};
    }
    missed += difference(levels[0], levels[1]).shows() ? 1 : 0;
  }
  EXPECT_NEAR(missed / 2000.0, 0.05, 0.015);
}

}  // namespace
}  // namespace granary
