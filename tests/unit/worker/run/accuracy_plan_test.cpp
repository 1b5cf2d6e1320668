#include "worker/run/accuracy_plan.h"

#include <gtest/gtest.h>

#include <cmath>

namespace granary::run {
namespace {

PilotMeans means_of(double base, double fine, double coarse, double deviation, unsigned count) {
  return {{Pilot::base, {base, deviation, count}},
          {Pilot::fine_step, {fine, deviation, count}},
          {Pilot::coarse_step, {coarse, deviation, count}}};
}

const std::map<Step, double> kCosts = {{Step::coarse, 0.5}, {Step::base, 1}, {Step::fine, 2}};

TEST(AccuracyPlan, takes_the_coarse_step_when_it_shows_no_bias_and_little_noise) {
  const Choice choice = choose(means_of(1, 1.0001, 0.9999, 2e-3, 8), kCosts, 0.01, 10, {});
  EXPECT_TRUE(choice.meets);
  EXPECT_EQ(choice.step, Step::coarse);
  EXPECT_EQ(choice.replicates, 2u);
}

TEST(AccuracyPlan, takes_a_finer_step_when_the_coarser_ones_are_biased) {
  const Choice choice = choose(means_of(1.03, 1.006, 1.08, 1e-4, 8), kCosts, 0.03, 10, {});
  EXPECT_TRUE(choice.meets);
  EXPECT_EQ(choice.step, Step::fine);
}

TEST(AccuracyPlan, buys_replicates_for_a_noisy_observable) {
  const Choice choice = choose(means_of(1, 1, 1, 0.02, 64), kCosts, 0.01, 10, {});
  EXPECT_TRUE(choice.meets);
  EXPECT_GT(choice.replicates, 10u);
  EXPECT_LE(choice.error, 0.01);
}

TEST(AccuracyPlan, says_when_noise_of_the_pilots_is_what_limits) {
  const Choice choice = choose(means_of(1, 1, 1, 0.02, 4), kCosts, 0.01, 10, {});
  EXPECT_FALSE(choice.meets);
  EXPECT_TRUE(choice.noise_limits);
}

TEST(AccuracyPlan, cannot_average_a_stiffness_error_away) {
  PilotMeans means = means_of(1, 1, 1, 1e-4, 8);
  means[Pilot::stiff] = {1.09, 1e-6, 8};
  for (auto& [pilot, level] : means) level.deviation = 1e-6;
  const Choice choice = choose(means, kCosts, 0.01, 10, {});
  EXPECT_FALSE(choice.meets);
  EXPECT_FALSE(choice.noise_limits);
  EXPECT_NEAR(error_parts(means, Step::base, 10).stiffness, 0.1, 1e-9);  // 0.09 * 10 / 9
}

TEST(AccuracyPlan, keeps_the_replicates_that_the_user_has_fixed) {
  EXPECT_EQ(choose(means_of(1, 1, 1, 0.02, 64), kCosts, 0.05, 10, 7u).replicates, 7u);
}

TEST(AccuracyPlan, first_order_bias_is_twice_the_difference_to_half_the_step) {
  const PilotMeans means = means_of(1.02, 1.01, 1.04, 1e-6, 4);
  EXPECT_NEAR(error_parts(means, Step::base, 10).discretisation, 0.02, 1e-9);
  EXPECT_NEAR(error_parts(means, Step::fine, 10).discretisation, 0.01, 1e-9);
  EXPECT_NEAR(error_parts(means, Step::coarse, 10).discretisation, 0.04, 1e-9);
}

TEST(AccuracyPlan, pooled_levels_are_those_of_all_samples_together) {
  const LevelMean a{1, 0, 1}, b{3, 0, 1};
  const LevelMean both = pooled(a, b);
  EXPECT_EQ(both.mean, 2);
  EXPECT_NEAR(both.deviation, std::sqrt(2.0), 1e-12);
  EXPECT_EQ(both.count, 2u);
}

v1::Decision by_user(const std::string& path) {
  v1::Decision decision;
  decision.set_path(path);
  decision.set_chosen_by("user");
  return decision;
}

TEST(AccuracyPlan, leaves_alone_what_the_user_has_fixed) {
  v1::Scene chute;
  chute.mutable_chute()->set_time_step_s(1e-5);
  chute.mutable_chute()->mutable_contact_pp()->set_normal_stiffness_n_per_m(1000);
  EXPECT_TRUE(pilot_scene(Pilot::coarse_step, chute, {}));
  EXPECT_TRUE(pilot_scene(Pilot::stiff, chute, {}));
  EXPECT_FALSE(pilot_scene(Pilot::coarse_step, chute, {by_user("chute.time_step_s")}));
  EXPECT_FALSE(
      pilot_scene(Pilot::stiff, chute, {by_user("chute.contact_pp.normal_stiffness_n_per_m")}));
  const auto fine = pilot_scene(Pilot::fine_step, chute, {by_user("chute.time_step_s")});
  EXPECT_EQ(fine->chute().time_step_s(), 5e-6);  // to know the error, not to run with it
}

TEST(ErrorParts, widen_the_error_and_are_named) {
  std::vector<core::ObservedValue> values = {{"f1_m", "m", 1.0, 0.03, "t-interval"},
                                             {"f2_m", "m", 1.0, 0.03, "t-interval"}};
  add_error_parts(values, {{"f1_m", {0.04, 0, 0, {}}}});
  EXPECT_NEAR(*values[0].error, 0.05, 1e-12);
  EXPECT_EQ(values[0].error_basis,
            "95 %: discretisation 0.04, stiffness 0, solver 0, sampling 0.03 (t-interval)");
  EXPECT_EQ(*values[1].error, 0.03);
  // Two replicates know their spread badly; that of all pilots is known.
  std::vector<core::ObservedValue> few = {{"f1_m", "m", 1.0, 0.4, "t-interval of 2"}};
  add_error_parts(few, {{"f1_m", {0.04, 0, 0, 0.03}}});
  EXPECT_NEAR(*few[0].error, 0.05, 1e-12);
}

}  // namespace
}  // namespace granary::run
