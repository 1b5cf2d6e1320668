#include "server/studies/golden_section.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace granary::server {
namespace {

// Maximises f with at most `parallel` evaluations at a time; returns (best t, rounds, evaluations).
struct Search {
  double best = 0;
  int rounds = 0;
  std::size_t evaluations = 0;
};
Search maximise(const std::function<double(double)>& f, std::size_t parallel, double width) {
  GoldenSection bracket = golden_section(0, 1);
  std::map<double, double> known;
  Search search;
  while (bracket.high - bracket.low > width) {
    for (const double t : next_points(bracket, known, parallel)) known[t] = f(t);
    ++search.rounds;
    while (known.count(bracket.left) && known.count(bracket.right))
      bracket = narrowed(bracket, known[bracket.left] >= known[bracket.right]);
  }
  search.best = (bracket.low + bracket.high) / 2;
  search.evaluations = known.size();
  return search;
}

TEST(GoldenSectionSearch, closes_in_on_the_maximum_with_one_evaluation_a_step) {
  const auto f = [](double t) { return -std::abs(t - 0.731); };
  const Search search = maximise(f, 1, 1e-3);
  EXPECT_NEAR(search.best, 0.731, 1e-3);
  // 0.618^n < 1e-3: n = 15 steps need n + 1 evaluations.
  EXPECT_EQ(search.evaluations, 16u);
}

TEST(GoldenSectionSearch, speculation_ends_at_the_same_bracket_in_fewer_rounds) {
  const auto f = [](double t) { return std::sin(3 * t); };
  const Search plain = maximise(f, 1, 1e-3);
  for (const std::size_t parallel : {2u, 3u, 4u, 7u}) {
    const Search many = maximise(f, parallel, 1e-3);
    EXPECT_NEAR(many.best, plain.best, 1e-3) << parallel;
    EXPECT_LT(many.rounds, plain.rounds) << parallel;
  }
  // Three at a time: one needed point and both its successors are two steps a round.
  EXPECT_LE(maximise(f, 3, 1e-3).rounds, plain.rounds / 2 + 1);
}

TEST(GoldenSectionSearch, never_asks_for_a_known_point_or_twice_for_one) {
  const GoldenSection bracket = golden_section(-1, 1);
  const auto first = next_points(bracket, {}, 6);
  ASSERT_EQ(first.size(), 6u);
  std::map<double, double> known;
  for (const double t : first) {
    EXPECT_EQ(known.count(t), 0u);
    known[t] = -t * t;
  }
  for (const double t : next_points(bracket, known, 6)) EXPECT_EQ(known.count(t), 0u);
}

}  // namespace
}  // namespace granary::server
