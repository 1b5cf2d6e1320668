// Each method on functions with a known optimum, and its state as data.
#include "server/studies/search_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "server/studies/gradual_deformation.h"
#include "server/studies/pareto.h"

namespace granary::server {
namespace {

using Function = std::function<std::vector<double>(const Point&)>;  // larger is better

double square(double x) {
  return x * x;
}

// Optimum 0 at (0.3, 0.7, 0.4).
std::vector<double> sphere(const Point& x) {
  return {-(square(x[0] - 0.3) + square(x[1] - 0.7) + square(x[2] - 0.4))};
}
// Rosenbrock's valley over [-2, 2]^2, optimum 0 at (1, 1), i.e. (0.75, 0.75) of the box.
std::vector<double> valley(const Point& x) {
  const double a = 4 * x[0] - 2, b = 4 * x[1] - 2;
  return {-(square(1 - a) + 100 * square(b - a * a))};
}
// Two spheres: the front is the straight line between their centres.
std::vector<double> two_spheres(const Point& x) {
  return {-(square(x[0] - 0.2) + square(x[1] - 0.5)), -(square(x[0] - 0.8) + square(x[1] - 0.5))};
}

v1::Optimize settings_of(v1::Optimize::Method method) {
  v1::Optimize settings;
  settings.set_method(method);
  settings.mutable_gradual_deformation()->set_line_evaluations(6);
  settings.mutable_gradual_deformation()->set_parallel(2);
  return settings;
}

struct History {
  std::vector<Scored> all;
  const Scored& best() const {
    return *std::max_element(all.begin(), all.end(),
                             [](const Scored& a, const Scored& b) { return a.merit < b.merit; });
  }
};

Scored score(const Point& point, const Function& function) {
  const auto terms = function(point);
  return {point, terms[0], terms};
}

History run(SearchMethod& method, const Function& function, std::size_t evaluations) {
  History history;
  while (history.all.size() < evaluations) {
    std::vector<Scored> batch;
    for (const Point& point : method.next_batch()) batch.push_back(score(point, function));
    EXPECT_FALSE(batch.empty());
    if (batch.empty()) break;
    method.take(batch);
    history.all.insert(history.all.end(), batch.begin(), batch.end());
  }
  return history;
}

// 300 evaluations of CMA-ES shrink its step by orders of magnitude in three dimensions (linear
// convergence, about a factor of ten per 60 evaluations); 1e-3 is a distance of 0.03.
TEST(CmaEs, reaches_the_optimum_of_a_sphere_and_of_a_curved_valley) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    auto on_sphere = make_search(settings_of(v1::Optimize::CMA_ES), {{0.5, 0.5, 0.5}, 1, 8, seed});
    EXPECT_GT(run(*on_sphere, sphere, 300).best().merit, -1e-3) << seed;
    auto in_valley = make_search(settings_of(v1::Optimize::CMA_ES), {{0.1, 0.9}, 1, 8, seed});
    EXPECT_GT(run(*in_valley, valley, 1500).best().merit, -1e-2) << seed;
  }
}

TEST(CmaEs, stays_inside_the_box) {
  const auto to_the_corner = [](const Point& x) { return std::vector<double>{x[0] + x[1]}; };
  auto method = make_search(settings_of(v1::Optimize::CMA_ES), {{0.5, 0.5}, 1, 8, 1});
  const History history = run(*method, to_the_corner, 200);
  for (const Scored& scored : history.all)
    for (const double coordinate : scored.point) {
      EXPECT_GE(coordinate, 0);
      EXPECT_LE(coordinate, 1);
    }
  EXPECT_GT(history.best().merit, 1.98);
}

// The front of two spheres is the segment between their centres: what nobody beats after 40
// generations must lie on it within a tenth of its length (0.06), and reach into both of its outer
// quarters.
TEST(NsgaII, finds_the_front_of_two_spheres) {
  auto method = make_search(settings_of(v1::Optimize::NSGA_II), {{0.5, 0.1}, 2, 16, 1});
  const History history = run(*method, two_spheres, 640);
  std::vector<std::vector<double>> terms;
  for (const Scored& scored : history.all) terms.push_back(scored.terms);
  const auto front = pareto_front(terms);
  EXPECT_GE(front.size(), 16u);
  double left = 1, right = 0;
  for (const std::size_t index : front) {
    const Point& x = history.all[index].point;
    EXPECT_NEAR(x[1], 0.5, 0.06);
    left = std::min(left, x[0]);
    right = std::max(right, x[0]);
  }
  EXPECT_LT(left, 0.35);
  EXPECT_GT(right, 0.65);
}

// 1 - (1 - v)^n with v the volume of a ball of radius 0.1 (0.0042): 500 draws miss it once in
// eight; radius 0.2 (0.0335) practically never.
TEST(RandomSearch, comes_near_the_optimum_by_numbers_alone) {
  auto method = make_search(settings_of(v1::Optimize::RANDOM_SEARCH), {{0.5, 0.5, 0.5}, 1, 10, 1});
  EXPECT_GT(run(*method, sphere, 500).best().merit, -0.04);
}

// A line search from x_i towards one random point, repeated: on a sphere it must gain with almost
// every line. 40 lines of 7 evaluations; reached: see the merit of each mixing.
TEST(GradualDeformationSearch, comes_near_the_optimum_of_a_sphere) {
  for (const auto mixing :
       {v1::Optimize::GradualDeformation::CONVEX, v1::Optimize::GradualDeformation::GAUSSIAN})
    for (const std::uint64_t seed : {1, 2, 3}) {
      v1::Optimize settings = settings_of(v1::Optimize::GRADUAL_DEFORMATION);
      settings.mutable_gradual_deformation()->set_mixing(mixing);
      auto method = make_search(settings, {{0.9, 0.1, 0.9}, 1, 8, seed});
      EXPECT_GT(run(*method, sphere, 300).best().merit, -0.01) << mixing << " seed " << seed;
    }
}

// The present point after each step, read out of the state, never gets worse, and is at least as
// good as both ends of the line just searched, on a function full of local maxima and with any
// parallelism.
TEST(GradualDeformationSearch, a_step_never_ends_worse_than_both_its_ends) {
  const auto rugged = [](const Point& x) {
    return std::vector<double>{std::sin(37 * x[0]) + std::cos(23 * x[1] + 5 * x[0]) -
                               square(x[0] - x[1])};
  };
  for (const std::uint32_t parallel : {1u, 2u, 3u, 5u}) {
    v1::Optimize settings = settings_of(v1::Optimize::GRADUAL_DEFORMATION);
    settings.mutable_gradual_deformation()->set_parallel(parallel);
    auto method = make_search(settings, {{0.5, 0.5}, 1, 8, parallel});
    double present = -1e300, end = -1e300;
    int steps = 0;
    for (int batch = 0; batch < 400; ++batch) {
      std::vector<Scored> scores;
      for (const Point& point : method->next_batch()) scores.push_back(score(point, rugged));
      ASSERT_LE(scores.size(), parallel);
      const Point before = method->save().at("end").get<Point>();
      for (const Scored& scored : scores)
        if (scored.point == before) end = scored.merit;
      method->take(scores);
      const auto state = method->save();
      if (state.at("end").get<Point>() == before) continue;  // the line goes on
      const double now = state.at("present_merit");
      EXPECT_GE(now, present);
      EXPECT_GE(now, end);
      EXPECT_EQ(now, rugged(state.at("present").get<Point>())[0]) << "merit belongs to the point";
      present = now;
      ++steps;
    }
    EXPECT_GT(steps, 50) << parallel;
  }
}

TEST(GradualDeformationSearch, convex_mixing_shrinks_and_gaussian_does_not) {
  // With merits that always prefer the mixture, CONVEX walks to the middle of the box; GAUSSIAN
  // keeps the spread of the draws: the mean square distance from the middle stays that of uniform
  // points.
  const auto spread = [](v1::Optimize::GradualDeformation::Mixing mixing) {
    v1::Optimize settings = settings_of(v1::Optimize::GRADUAL_DEFORMATION);
    settings.mutable_gradual_deformation()->set_mixing(mixing);
    double sum = 0;
    int count = 0, evaluation = 0;
    auto method = make_search(settings, {{0.5}, 1, 8, 7});
    const auto newest_wins = [&](const Point&) { return std::vector<double>{1.0 * ++evaluation}; };
    for (int batch = 0; batch < 4000; ++batch) {
      std::vector<Scored> scores;
      for (const Point& point : method->next_batch()) scores.push_back(score(point, newest_wins));
      method->take(scores);
      sum += square(method->save().at("present").get<Point>()[0] - 0.5);
      ++count;
    }
    return sum / count;
  };
  const double uniform = 1.0 / 12;
  EXPECT_LT(spread(v1::Optimize::GradualDeformation::CONVEX), 0.8 * uniform);
  EXPECT_GT(spread(v1::Optimize::GradualDeformation::GAUSSIAN), 0.8 * uniform);
}

class EveryMethod : public testing::TestWithParam<v1::Optimize::Method> {};

// The state goes through bytes before and after every batch: not one point may change.
TEST_P(EveryMethod, continues_from_its_state_bit_by_bit) {
  const bool front = GetParam() == v1::Optimize::NSGA_II;
  const SearchSetup setup{{0.5, 0.5}, front ? 2u : 1u, 8, 11};
  const Function function = front ? Function(two_spheres) : Function(valley);
  auto undisturbed = make_search(settings_of(GetParam()), setup);
  const History expected = run(*undisturbed, function, 200);
  auto method = make_search(settings_of(GetParam()), setup);
  const auto reborn = [&] {
    const auto bytes = nlohmann::json::to_cbor(method->save());
    method = make_search(settings_of(GetParam()), setup);
    method->restore(nlohmann::json::from_cbor(bytes));
  };
  std::size_t seen = 0;
  while (seen < 200) {
    reborn();
    const auto batch = method->next_batch();
    std::vector<Scored> scores;
    for (const Point& point : batch) {
      EXPECT_EQ(point, expected.all[seen].point) << "evaluation " << seen;
      scores.push_back(score(point, function));
      if (++seen >= expected.all.size()) break;
    }
    if (scores.size() < batch.size()) break;
    reborn();
    method->take(scores);
  }
}

TEST_P(EveryMethod, another_seed_looks_elsewhere) {
  const bool front = GetParam() == v1::Optimize::NSGA_II;
  std::vector<std::vector<Point>> second;
  for (const std::uint64_t seed : {1, 2}) {
    auto method = make_search(settings_of(GetParam()), {{0.5, 0.5}, front ? 2u : 1u, 8, seed});
    const History history = run(*method, front ? Function(two_spheres) : Function(valley), 30);
    std::vector<Point> points;
    for (const Scored& scored : history.all) points.push_back(scored.point);
    second.push_back(points);
  }
  EXPECT_NE(second[0], second[1]);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod,
                         testing::Values(v1::Optimize::GRADUAL_DEFORMATION, v1::Optimize::CMA_ES,
                                         v1::Optimize::NSGA_II, v1::Optimize::RANDOM_SEARCH),
                         [](const auto& each) { return v1::Optimize::Method_Name(each.param); });

TEST(ParetoFront, keeps_what_nobody_beats_in_everything) {
  EXPECT_EQ(pareto_front({{1, 1}, {2, 0}, {0, 2}, {0.5, 0.5}, {2, 0}, {1, 0}}),
            (std::vector<std::size_t>{0, 1, 2, 4}));
  EXPECT_TRUE(pareto_front({}).empty());
}

}  // namespace
}  // namespace granary::server
