// Claim: a run that recovers is as reproducible as one that does not: where it is cut into chunks,
//   checkpointed, killed and resumed changes no bit, and a resumed run carries the changed setting.
// Method: one NaN is injected into each engine; runs with frames, checkpoints after every chunk,
// and
//   releases in between are compared with an undisturbed one by state hash and frames.
// Tolerance: bitwise. Seconds: 3.
#include <gtest/gtest.h>

#include "tests/stability/hard_case.h"
#include "tests/support/result_reader.h"
#include "tests/support/temporary_directory.h"
#include "worker/run/run_task.h"
#include "worker/run/task_setup.h"
#include "worker/scene/chute.h"
#include "worker/scene/discharge.h"
#include "worker/storage/verify.h"

namespace granary::stability {
namespace {

using granary::testing::TemporaryDirectory;

std::unique_ptr<core::Simulation> make_engine(const v1::Scene& scene, const core::State* filling) {
  if (scene.has_discharge()) return scene::make_discharge(scene, filling);
  return scene::make_chute(scene, filling);
}

const HardCase& case_of(const std::string& name) {
  for (const HardCase& hard_case : hard_cases())
    if (hard_case.name == name) return hard_case;
  throw std::logic_error("no such case: " + name);
}

class RecoveredRun : public ::testing::TestWithParam<const char*> {
 protected:
  run::TaskSpec spec_of(const std::string& file) {
    const HardCase& hard_case = case_of(GetParam());
    const auto scene = load_scene(hard_case.scene, "case.txtpb", hard_case.settings);
    run::TaskSpec spec = *run::make_task(*scene, {make_engine, "portable"});
    spec.result_path = directory / (file + ".h5");
    spec.work_directory = directory / (file + ".parts");
    return spec;
  }
  // Interventions are counted per run, over all its attempts.
  run::SimulationFactory meddled() {
    const auto done = std::make_shared<std::uint64_t>(0);
    const HardCase& hard_case = case_of(GetParam());
    return [done, &hard_case](const v1::Scene& scene, const core::State* filling) {
      return std::make_unique<granary::testing::MeddledSimulation>(make_engine(scene, filling),
                                                                   *hard_case.meddling, done);
    };
  }

  TemporaryDirectory directory;
  run::StopSignal stop{run::StopRequest::none};
};

std::vector<std::string> changed_settings(const v1::Result& result) {
  std::vector<std::string> texts;
  for (const v1::Decision& decision : result.decisions())
    if (decision.chosen_by() == "recovery") texts.push_back(decision.path() + decision.value());
  return texts;
}

TEST_P(RecoveredRun, is_bitwise_the_same_with_checkpoints_and_releases) {
  const run::TaskSpec whole = spec_of("whole");
  const run::TaskOutcome expected = run::run_task(whole, meddled(), {}, stop);
  ASSERT_EQ(expected.outcome, v1::TaskFinished::COMPLETE) << expected.message;
  ASSERT_EQ(changed_settings(expected.result).size(), 1u);

  run::TaskSpec pieces = spec_of("pieces");
  pieces.checkpoint_interval_s = 0;
  pieces.scene.mutable_output()->set_frames(100);
  const run::SimulationFactory factory = meddled();
  run::TaskOutcome outcome;
  int attempts = 0;
  do {
    ASSERT_LT(++attempts, 1000);
    stop = run::StopRequest::none;
    int events = 0;
    run::TaskCallbacks callbacks;
    callbacks.progress = [&](const v1::Progress&) {
      if (++events == 2) stop = run::StopRequest::release;
    };
    outcome = run::run_task(pieces, factory, callbacks, stop);
  } while (outcome.outcome == v1::TaskFinished::RELEASED);
  ASSERT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE) << outcome.message;
  EXPECT_EQ(outcome.result.state_hash(), expected.result.state_hash());
  EXPECT_EQ(changed_settings(outcome.result), changed_settings(expected.result));
  EXPECT_EQ(outcome.result.cost().steps(), expected.result.cost().steps());
}

TEST_P(RecoveredRun, keeps_no_frame_of_what_it_went_back_over) {
  const run::TaskSpec spec = spec_of("frames");
  ASSERT_EQ(run::run_task(spec, meddled(), {}, stop).outcome, v1::TaskFinished::COMPLETE);
  const storage::VerifyReport report = storage::verify_result(spec.result_path);
  EXPECT_TRUE(report.ok()) << report.problems.front();
  const auto stored = granary::testing::read_result(spec.result_path);
  double before = -1;
  for (std::uint64_t k = 0; k < report.frame_count; ++k) {
    char path[40];
    std::snprintf(path, sizeof path, "/frames/%06llu@time_s", static_cast<unsigned long long>(k));
    ASSERT_TRUE(stored.numbers.contains(path)) << path;
    EXPECT_GT(stored.numbers.at(path), before) << path;
    before = stored.numbers.at(path);
  }
  EXPECT_GE(report.frame_count, 100u);
}

INSTANTIATE_TEST_SUITE_P(, RecoveredRun,
                         ::testing::Values("dda_nan_injected_once", "dem_nan_injected_once"),
                         [](const auto& info) { return std::string(info.param).substr(0, 3); });

// A collision is in progress at every step of these scenes' impacts: resumed after each single one.
class ResumedInCollision : public ::testing::TestWithParam<const char*> {};

TEST_P(ResumedInCollision, goes_on_bitwise_from_every_step_of_it) {
  const HardCase& hard_case = case_of(GetParam());
  const auto scene = load_scene(hard_case.scene, "case.txtpb", hard_case.settings);
  const run::TaskSpec spec = *run::make_task(*scene, {make_engine, "portable"});
  const auto whole = make_engine(spec.scene, nullptr);
  auto pieces = make_engine(spec.scene, nullptr);
  for (int k = 0; k < 400; ++k) {
    ASSERT_NE(whole->advance(1e9, 1).status, core::AdvanceStatus::rejected);
    const core::State state = pieces->snapshot();
    pieces = make_engine(spec.scene, nullptr);
    pieces->restore(state);
    pieces->advance(1e9, 1);
    ASSERT_EQ(core::hash_columns(whole->physical_state()),
              core::hash_columns(pieces->physical_state()))
        << "step " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(, ResumedInCollision,
                         ::testing::Values("dda_inner_corner_hit_exactly",
                                           "dda_initial_overlap_of_0_4_radii",
                                           "dem_initial_overlap_of_0_4_radii", "dem_step_tiny"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace granary::stability
