// Optimizations with made-up evaluations: the whole generator, without jobs.
#include "server/studies/optimize.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <set>

#include "proto/contract/scene_text.h"

namespace granary::server {
namespace {

using testing::HasSubstr;

v1::StudySpec spec_of(v1::Optimize::Method method, std::uint32_t budget) {
  v1::StudySpec spec;
  *spec.mutable_scene() = parse_scene(
                              "seed: 5 discharge { particles { count: 20 diameter_min_m: 0.01 "
                              "density_kg_per_m3: 2200 } "
                              "bucket { shape: BEZIER x2_m: -0.5 x3_m: -0.5 x4_m: -0.5 } "
                              "friction_pp_deg: 30 friction_pw_deg: 20 rotation_rad_per_s: 10 }",
                              "test")
                              ->scene;
  v1::Optimize& settings = *spec.mutable_optimize();
  settings.set_method(method);
  settings.set_budget(budget);
  for (const char* path :
       {"discharge.bucket.x2_m", "discharge.bucket.x3_m", "discharge.bucket.x4_m"}) {
    auto& variable = *settings.add_vary();
    variable.set_path(path);
    variable.set_minimum(-1);
    variable.set_maximum(0);
  }
  auto& far = *settings.add_objective();
  far.set_value("f1_m");
  if (method == v1::Optimize::NSGA_II) {
    auto& compact = *settings.add_objective();
    compact.set_value("f4_m");
    compact.set_goal(v1::Optimize::MINIMISE);
    compact.set_weight(0);  // on the front, not in the sum
  }
  return spec;
}

// A discharge made up: far for x = (-0.3, -0.6, -0.2), with noise from the seed.
struct World {
  double noise = 0;
  double fill_ratio = 1;
  std::function<bool(const v1::Scene&)> fails = [](const v1::Scene&) { return false; };

  TrialOutcome run(const v1::Scene& scene) const {
    TrialOutcome outcome;
    if (fails(scene)) {
      outcome.state = v1::UNSTABLE;
      outcome.error = "unstable";
      return outcome;
    }
    const auto& bucket = scene.discharge().bucket();
    const double away = std::pow(bucket.x2_m() + 0.3, 2) + std::pow(bucket.x3_m() + 0.6, 2) +
                        std::pow(bucket.x4_m() + 0.2, 2);
    std::mt19937_64 random(scene.seed() * 1000 + static_cast<std::uint64_t>(1e6 * away));
    outcome.state = v1::COMPLETE;
    const auto put = [&](const char* name, double value) {
      (*outcome.result.mutable_values())[name].set_value(value);
    };
    put("f1_m", 2 - away + noise * std::normal_distribution<double>()(random));
    put("f4_m", 1 + std::pow(bucket.x2_m() + 0.8, 2));
    put("fill_ratio", fill_ratio);
    return outcome;
  }
};

std::unique_ptr<StudyGenerator> made(const v1::StudySpec& spec) {
  auto generator = make_optimize(spec);
  EXPECT_TRUE(generator.ok()) << generator.error().message;
  return std::move(*generator);
}

struct Told {
  std::string label, role;
  std::uint64_t seed;
  std::uint32_t candidate;
  std::optional<double> objective, error;
  std::optional<bool> feasible;
  bool operator==(const Told&) const = default;
};

// Everything that is asked is told in order, two at a time, until the generator is done. `disturb`
// is called between any two steps and may replace the generator.
std::vector<Told> play(
    std::unique_ptr<StudyGenerator>& generator, const World& world,
    const std::function<void()>& disturb = [] {}) {
  std::vector<Told> history;
  std::vector<TrialProposal> open;
  std::uint32_t told = 0;
  for (int guard = 0; guard < 100'000; ++guard) {
    disturb();
    for (TrialProposal& proposal : generator->ask(2 - std::min<std::size_t>(2, open.size())))
      open.push_back(std::move(proposal));
    if (open.empty()) break;
    disturb();
    const TrialProposal next = open.front();
    open.erase(open.begin());
    const TrialJudgement judged = generator->tell(++told, world.run(next.scene));
    history.push_back({next.label, next.role, next.scene.seed(), next.candidate, judged.objective,
                       judged.objective_error, judged.feasible});
  }
  EXPECT_TRUE(generator->done());
  return history;
}

class Method : public testing::TestWithParam<v1::Optimize::Method> {};

TEST_P(Method, spends_its_whole_budget_and_finds_something_better_than_the_start) {
  auto generator = made(spec_of(GetParam(), 120));
  const auto history = play(generator, {});
  EXPECT_EQ(history.size(), 120u);
  EXPECT_EQ(history[0].role, "start");
  const v1::StudySummary summary = generator->summary();
  // f1 = 2 - away: 1.86 / 1.86 = 1 at the start (away = 0.14), 2 / 1.86 = 1.075 at best. Half of
  // the way is what 120 random points reach with near certainty (a ball of radius 0.26 is 8 % of
  // the box).
  EXPECT_GT(summary.best_objective(), 1 + 0.5 * 0.075) << summary.verdict();
  EXPECT_THAT(summary.verdict(), HasSubstr("better than the start"));
}

TEST_P(Method, a_killed_study_continues_with_the_same_proposals) {
  auto undisturbed = made(spec_of(GetParam(), 60));
  const auto expected = play(undisturbed, {0.05});
  // Twenty lives, each ended between two random steps.
  std::mt19937 dice(static_cast<unsigned>(GetParam()));
  auto generator = made(spec_of(GetParam(), 60));
  int deaths = 0;
  const auto history = play(generator, {0.05}, [&] {
    if (deaths == 20 || dice() % 3 != 0) return;
    ++deaths;
    const std::string state = generator->save();
    generator = made(spec_of(GetParam(), 60));
    generator->restore(state);
  });
  EXPECT_EQ(deaths, 20);
  EXPECT_EQ(history, expected);
  EXPECT_EQ(generator->summary().verdict(), undisturbed->summary().verdict());
}

TEST_P(Method, failed_runs_are_lived_with) {
  World world;
  world.fails = [](const v1::Scene& scene) { return scene.discharge().bucket().x2_m() < -0.5; };
  auto generator = made(spec_of(GetParam(), 100));
  EXPECT_EQ(play(generator, world).size(), 100u);
  EXPECT_GT(generator->summary().best_objective(), 1.0);
}

TEST_P(Method, nothing_that_breaks_a_constraint_is_ever_the_best) {
  World world;
  world.fill_ratio = 0.9;  // below the 0.95 that every discharge has to keep
  auto generator = made(spec_of(GetParam(), 40));
  play(generator, world);
  EXPECT_FALSE(generator->summary().has_best_trial());
  EXPECT_THAT(generator->summary().verdict(), HasSubstr("constraint"));
}

INSTANTIATE_TEST_SUITE_P(Optimize, Method,
                         testing::Values(v1::Optimize::GRADUAL_DEFORMATION, v1::Optimize::CMA_ES,
                                         v1::Optimize::NSGA_II, v1::Optimize::RANDOM_SEARCH),
                         [](const auto& each) { return v1::Optimize::Method_Name(each.param); });

TEST(Optimize, weights_normalisation_and_floor_are_those_of_equation_12) {
  // f = a1 f1/f1(x0) - a3 f3/max(f3(x0), floor): f3(x0) = 0 must not divide by zero.
  v1::StudySpec spec = spec_of(v1::Optimize::RANDOM_SEARCH, 3);
  spec.mutable_optimize()->mutable_objective(0)->set_weight(2);
  auto& rest = *spec.mutable_optimize()->add_objective();
  rest.set_value("f3_percent");
  rest.set_goal(v1::Optimize::MINIMISE);
  rest.set_weight(3);
  rest.set_floor(1);
  auto generator = made(spec);
  const auto result = [](double f1, double f3) {
    TrialOutcome outcome;
    outcome.state = v1::COMPLETE;
    (*outcome.result.mutable_values())["f1_m"].set_value(f1);
    (*outcome.result.mutable_values())["f3_percent"].set_value(f3);
    (*outcome.result.mutable_values())["fill_ratio"].set_value(1);
    return outcome;
  };
  generator->ask(3);
  EXPECT_DOUBLE_EQ(*generator->tell(1, result(1.6, 0)).objective, 2);
  EXPECT_DOUBLE_EQ(*generator->tell(2, result(2.0, 0.5)).objective, 2 * 2.0 / 1.6 - 3 * 0.5);
  EXPECT_DOUBLE_EQ(*generator->tell(3, result(0.8, 2)).objective, 2 * 0.8 / 1.6 - 3 * 2.0);
}

TEST(Optimize, noise_is_answered_with_other_seeds_until_the_best_is_decided) {
  v1::StudySpec spec = spec_of(v1::Optimize::RANDOM_SEARCH, 60);
  spec.mutable_optimize()->mutable_noise()->set_replicates(2);
  spec.mutable_optimize()->mutable_noise()->set_replicates_max(8);
  auto generator = made(spec);
  const auto history = play(generator, {0.02});
  std::map<std::uint32_t, std::set<std::uint64_t>> seeds;
  for (const Told& told : history) seeds[told.candidate].insert(told.seed);
  std::size_t most = 0;
  for (const auto& [candidate, used] : seeds) {
    EXPECT_EQ(*used.begin(), 5u) << "the same seeds for all: paired";
    most = std::max(most, used.size());
  }
  EXPECT_GT(most, 2u) << "the best are repeated";
  EXPECT_LE(most, 8u);
  EXPECT_TRUE(generator->summary().has_best_objective_error());
}

TEST(Optimize, says_so_when_there_is_no_significant_improvement) {
  // The start is the optimum; noise alone makes others look better.
  v1::StudySpec spec = spec_of(v1::Optimize::RANDOM_SEARCH, 80);
  const double best[] = {-0.3, -0.6, -0.2};
  for (int i = 0; i < 3; ++i) {
    auto& variable = *spec.mutable_optimize()->mutable_vary(i);
    variable.set_start(best[i]);
    variable.set_minimum(best[i] - 0.02);
    variable.set_maximum(best[i] + 0.02);
  }
  spec.mutable_optimize()->mutable_noise()->set_replicates(2);
  spec.mutable_optimize()->mutable_noise()->set_replicates_max(6);
  auto generator = made(spec);
  play(generator, {0.05});
  EXPECT_THAT(generator->summary().verdict(),
              testing::AnyOf(HasSubstr("no significant improvement"),
                             HasSubstr("nothing better than the start")));
}

TEST(Optimize, coarse_runs_come_first_and_only_the_best_are_run_in_full) {
  v1::StudySpec spec = spec_of(v1::Optimize::CMA_ES, 90);
  spec.mutable_optimize()->set_population(8);
  auto& coarse = *spec.mutable_optimize()->mutable_coarse();
  coarse.add_set("discharge.particles.count=10");
  coarse.set_promote(0.25);
  auto generator = made(spec);
  const auto history = play(generator, {});
  std::map<std::string, int> roles;
  for (const Told& told : history) ++roles[told.role];
  EXPECT_GT(roles["coarse"], 3 * roles["promoted"]);
  EXPECT_GT(roles["promoted"], 10);
  EXPECT_GT(generator->summary().best_objective(), 1.03);
}

TEST(Optimize, extend_takes_up_where_it_ended) {
  auto whole = made(spec_of(v1::Optimize::CMA_ES, 60));
  const auto expected = play(whole, {});
  auto generator = made(spec_of(v1::Optimize::CMA_ES, 35));
  World world;
  std::vector<Told> history;
  std::uint32_t told = 0;
  for (const std::uint32_t budget : {35u, 60u}) {
    if (budget > 35) {
      ASSERT_TRUE(generator->extend(budget).ok());
    }
    for (auto open = generator->ask(1); !open.empty(); open = generator->ask(1)) {
      const auto judged = generator->tell(++told, world.run(open[0].scene));
      history.push_back({open[0].label, open[0].role, open[0].scene.seed(), open[0].candidate,
                         judged.objective, judged.objective_error, judged.feasible});
    }
  }
  EXPECT_EQ(history, expected);
  EXPECT_EQ(generator->extend(60).error().code, ErrorCode::invalid_argument);
}

TEST(Optimize, nsga_ii_leaves_a_front_of_trade_offs) {
  auto generator = made(spec_of(v1::Optimize::NSGA_II, 160));
  play(generator, {});
  const auto findings = generator->findings();
  ASSERT_TRUE(findings.has_value());
  // f1 wants x2 = -0.3, f4 wants x2 = -0.8: many shapes between are on the front.
  EXPECT_GT(findings->pareto.size(), 5u);
}

TEST(Optimize, refuses_what_cannot_be_optimized) {
  struct Case {
    std::function<void(v1::StudySpec&)> spoil;
    const char* message;
  };
  using S = v1::StudySpec;
  const std::vector<Case> cases = {
      {[](S& s) { s.mutable_optimize()->clear_vary(); }, "vary: is empty"},
      {[](S& s) { s.mutable_optimize()->clear_objective(); }, "objective: is empty"},
      {[](S& s) { s.mutable_optimize()->clear_budget(); }, "budget"},
      {[](S& s) { s.mutable_optimize()->mutable_vary(0)->set_path("discharge.bucket.x9_m"); },
       "x9_m"},
      {[](S& s) { s.mutable_optimize()->mutable_vary(0)->set_minimum(1); }, "below maximum"},
      {[](S& s) { s.mutable_optimize()->mutable_vary(0)->clear_maximum(); }, "maximum"},
      {[](S& s) { s.mutable_optimize()->mutable_objective(0)->set_weight(-1); }, "weight"},
      {[](S& s) { s.mutable_optimize()->set_method(v1::Optimize::NSGA_II); }, "two terms"},
      {[](S& s) { s.mutable_optimize()->add_constraint()->set_value("f1_m"); },
       "minimum or a maximum"},
      {[](S& s) { s.mutable_optimize()->mutable_coarse()->add_set("nonsense"); }, "path=value"},
      {[](S& s) {
         s.mutable_optimize()->mutable_noise()->set_replicates(4),
             s.mutable_optimize()->mutable_noise()->set_replicates_max(2);
       },
       "replicates"},
      {[](S& s) { s.clear_scene(); }, "scene"},
  };
  for (const Case& each : cases) {
    v1::StudySpec spec = spec_of(v1::Optimize::CMA_ES, 10);
    each.spoil(spec);
    const auto generator = make_generator(spec);
    ASSERT_FALSE(generator.ok()) << each.message;
    EXPECT_THAT(generator.error().message, HasSubstr(each.message));
  }
}

}  // namespace
}  // namespace granary::server
