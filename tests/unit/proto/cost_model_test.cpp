// Claim: predicted CPU seconds of the shipped scenes lie within their interval of what they cost.
// Reference: CPU seconds of one core of a 2-core Zen 4, release build, 2026-11-22.
#include "proto/contract/cost_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/support/shipped_scenes.h"

namespace granary {
namespace {

using tests::shipped_scene;

struct Measured {
  const char* scene;
  double cpu_s;
  double particle_steps;
};

TEST(CostModel, intervals_hold_what_shipped_scenes_cost) {
  for (const Measured& measured : {Measured{"discharge_small", 0.103, 1.83e6},
                                   {"discharge_700_centrifugal", 0.313, 6.57e6},
                                   {"discharge_700_gravity", 0.652, 9.8e6},
                                   {"discharge_4000_straight", 2.25, 5.37e7},
                                   {"chute_small", 0.578, 8.84e7}}) {
    const CostEstimate estimate = predict_cost(shipped_scene(measured.scene), Calibration());
    EXPECT_LT(estimate.cpu_s.low, measured.cpu_s) << measured.scene;
    EXPECT_GT(estimate.cpu_s.high, measured.cpu_s) << measured.scene;
    // The work itself is counted, not measured: within 40 %.
    EXPECT_NEAR(std::log(estimate.particle_steps / measured.particle_steps), 0, 0.35)
        << measured.scene;
  }
}

TEST(CostModel, counts_replicates_and_smaller_steps) {
  const v1::Scene scene = shipped_scene("chute_small");
  v1::Scene more = scene;
  more.set_replicates(4);
  v1::Scene finer = scene;
  finer.mutable_chute()->set_time_step_s(scene.chute().time_step_s() / 2);
  const double steps = predict_cost(scene, Calibration()).particle_steps;
  EXPECT_NEAR(predict_cost(more, Calibration()).particle_steps, 4 * steps, 1e-9 * steps);
  EXPECT_NEAR(predict_cost(finer, Calibration()).particle_steps, 2 * steps, 1e-3 * steps);
}

TEST(CostModel, budget_is_kept_by_the_upper_end_of_the_interval) {
  const v1::Scene scene = shipped_scene("discharge_700_centrifugal");
  const Calibration none;
  const BudgetChoice choice = fit_budget(scene, none, 60);
  EXPECT_TRUE(choice.fits);
  ASSERT_TRUE(choice.replicates && choice.time_step_s && choice.particles);
  v1::Scene most = scene;
  most.set_replicates(*choice.replicates);
  EXPECT_LE(predict_cost(most, none).cpu_s.high, 60);
  most.set_replicates(*choice.replicates + 1);
  EXPECT_GT(predict_cost(most, none).cpu_s.high, 60);
  EXPECT_LT(*choice.time_step_s, scene.discharge().time_step_s());
  EXPECT_GT(*choice.particles, 700u);
  EXPECT_FALSE(fit_budget(scene, none, 1e-3).fits);
  EXPECT_FALSE(fit_budget(scene, none, 1e-3).replicates);
}

TEST(Calibration, narrows_and_shifts_with_runs_and_survives_its_file) {
  Calibration calibration;
  const double shipped = calibration.log_half_width("chute");
  for (int k = 0; k < 10; ++k) calibration.note("chute", 2.0 * (k % 2 == 0 ? 1.05 : 0.95));
  EXPECT_LT(calibration.log_half_width("chute"), 0.7 * shipped);
  EXPECT_NEAR(std::exp(calibration.find("chute")->log_mean), 2, 0.05);
  const auto path = std::filesystem::temp_directory_path() / "granary-calibration-test" / "file";
  ASSERT_TRUE(calibration.save(path));
  const Calibration back = Calibration::load(path);
  EXPECT_NEAR(back.find("chute")->log_mean, calibration.find("chute")->log_mean, 1e-9);
  EXPECT_EQ(back.find("discharge"), nullptr);
  std::filesystem::remove_all(path.parent_path());
}

TEST(Calibration, passes_over_damaged_lines_and_impossible_numbers) {
  const auto path = std::filesystem::temp_directory_path() / "granary-calibration-damaged";
  std::ofstream(path) << "chute nan 0 0\ndischarge 3 0.1\n\nchute -1 0 0\nok 2 0.5 0.1\n";
  const Calibration calibration = Calibration::load(path);
  EXPECT_EQ(calibration.find("chute"), nullptr);
  EXPECT_EQ(calibration.find("discharge"), nullptr);
  EXPECT_NE(calibration.find("ok"), nullptr);
  std::filesystem::remove(path);
  EXPECT_EQ(Calibration::load("/nowhere/at/all").find("ok"), nullptr);
}

}  // namespace
}  // namespace granary
