// Claim: at fixed restitution a discharge depends neither on the step (5e-5 to 2e-4 s) nor on the
//   penalty (1e6 to 1e8 N/m): f1 and f2 within 1 %, f4 within 2 %, f3 within 1.5 points of the
//   limit of small steps.
// Method: 800 disks of 3 mm in a bucket like discharge_4000_straight's, three fillings each; limit
// =
//   K 1e7, dt 5e-5 with K h^2 / m <= 0.06 and tolerance 0.05.
// Reference: itself; the whole ladder with 4000 disks is in tests/bench/results/dda_ladder.md.
// Tolerance: the claim's margins plus the 95 % interval of the difference of two means; the spread
// is
//   that between fillings (chaos: PHYSICS D5), pooled over all settings because three values alone
//   know their spread badly.
// Seconds: 12
#include <gtest/gtest.h>

#include "tests/physics/papers/scoreboard.h"

namespace granary::tests {
namespace {

constexpr int kFillings = 3;

struct Setting {
  const char* stiffness;
  const char* time_step;
  bool limit;
};

std::vector<DischargeRun> runs_at(const Setting& setting) {
  std::vector<DischargeRun> runs;
  for (int seed = 1; seed <= kFillings; ++seed) {
    std::vector<std::pair<std::string, std::string>> settings = {
        {"seed", std::to_string(seed)},
        {"discharge.particles.count", "800"},
        {"discharge.bucket.tip_x_m", "-0.18"},
        {"discharge.bucket.tip_y_m", "0.18"},
        {"discharge.penalty.stiffness_n_per_m", setting.stiffness},
        {"discharge.time_step_s", setting.time_step}};
    if (setting.limit) settings.emplace_back("discharge.solver.tolerance", "0.05");
    scene::DischargePlan plan = plan_of("discharge_4000_straight", settings);
    if (setting.limit) plan.solver.small_step_kappa = 0.06;
    runs.push_back(run_discharge(plan));
  }
  return runs;
}

TEST(Independence, of_step_and_penalty_at_fixed_restitution) {
  const auto limit = runs_at({"1e7", "5e-5", true});
  std::vector<std::vector<DischargeRun>> settings;
  for (const Setting& s : {Setting{"1e7", "2e-4", false}, Setting{"1e6", "2e-4", false},
                           Setting{"1e8", "1e-4", false}})
    settings.push_back(runs_at(s));
  const double student = 2.306;  // 8 degrees of freedom: four settings of three fillings
  for (const auto& [value, margin] :
       {std::pair{"f1_m", 0.01}, {"f2_m", 0.01}, {"f4_m", 0.02}, {"f3_percent", 1.5}}) {
    const char* const name = value;  // lambdas of C++20 cannot hold a part of a binding in clang 14
    const double reference = value_over(limit, name).mean;
    double squares = 0;
    const auto add_spread = [&](const std::vector<DischargeRun>& runs) {
      const double mean = value_over(runs, name).mean;
      for (const DischargeRun& run : runs)
        squares += (run.values.at(name) - mean) * (run.values.at(name) - mean);
    };
    add_spread(limit);
    for (const auto& runs : settings) add_spread(runs);
    const double interval = student * std::sqrt(squares / 8 * 2 / kFillings);
    const double allowed = (name == std::string("f3_percent") ? margin : margin * reference);
    EXPECT_LT(interval, 4 * allowed) << name << ": too noisy to say anything";
    for (std::size_t k = 0; k < settings.size(); ++k)
      EXPECT_NEAR(value_over(settings[k], name).mean, reference, allowed + interval)
          << name << " of setting " << k;
  }
}

}  // namespace
}  // namespace granary::tests
