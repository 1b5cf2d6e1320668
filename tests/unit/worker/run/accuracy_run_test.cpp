#include "worker/run/accuracy_run.h"

#include <gtest/gtest.h>

#include "tests/support/result_reader.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/toy_simulation.h"

namespace granary::run {
namespace {

using namespace granary::testing;

TaskSpec spec_of(const std::string& observable, double target) {
  TaskSpec spec;
  spec.scene = toy_scene();
  spec.scene.mutable_accuracy()->set_target(target);
  spec.scene.mutable_accuracy()->set_observable(observable);
  spec.scene_key = "key of the toy";
  spec.engine_version = "toy 1";
  spec.vector_path = "portable";
  return spec;
}

std::string chosen(const v1::Result& result, const std::string& path) {
  for (const v1::Decision& decision : result.decisions())
    if (decision.path() == path) return decision.value();
  return "";
}

TEST(AccuracyRun, gives_every_value_with_all_parts_of_its_error) {
  TemporaryDirectory directory;
  const StopSignal stop{StopRequest::none};
  TaskSpec spec = spec_of("f1_m", 0.4);
  spec.result_path = directory / "r.h5";
  spec.work_directory = directory / "r.parts";
  const TaskOutcome outcome = run_request(spec, toy_factory(), {}, stop);
  ASSERT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE) << outcome.message;
  const v1::Quantity& f1 = outcome.result.values().at("f1_m");
  for (const char* part : {"discretisation", "stiffness", "solver", "sampling", "replicates"})
    EXPECT_NE(f1.error_basis().find(part), std::string::npos) << f1.error_basis();
  EXPECT_NE(chosen(outcome.result, "replicates"), "");
  EXPECT_NE(chosen(outcome.result, "discharge.time_step_s"), "");
  // The file says the same.
  const StoredResult stored = read_result(directory / "r.h5");
  EXPECT_EQ(stored.numbers.at("/values/f1_m@error"), f1.error());
}

TEST(AccuracyRun, chooses_the_same_every_time) {
  const StopSignal stop{StopRequest::none};
  const TaskOutcome a = run_request(spec_of("f1_m", 0.4), toy_factory(), {}, stop);
  const TaskOutcome b = run_request(spec_of("f1_m", 0.4), toy_factory(), {}, stop);
  EXPECT_EQ(a.result.state_hash(), b.result.state_hash());
  EXPECT_EQ(chosen(a.result, "replicates"), chosen(b.result, "replicates"));
}

TEST(AccuracyRun, says_what_could_be_met_when_the_target_cannot) {
  const StopSignal stop{StopRequest::none};
  const TaskOutcome outcome = run_request(spec_of("f1_m", 1e-6), toy_factory(), {}, stop);
  ASSERT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE) << outcome.message;
  std::string warnings;
  for (const std::string& warning : outcome.result.warnings()) warnings += warning + "\n";
  EXPECT_NE(warnings.find("is not reached"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("could"), std::string::npos) << warnings;
}

TEST(AccuracyRun, refuses_an_observable_that_the_scene_does_not_give) {
  const StopSignal stop{StopRequest::none};
  const TaskOutcome outcome = run_request(spec_of("f9_m", 0.1), toy_factory(), {}, stop);
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::ERROR);
  EXPECT_NE(outcome.message.find("accuracy.observable"), std::string::npos);
  EXPECT_NE(outcome.message.find("f1_m"), std::string::npos) << outcome.message;
}

TEST(AccuracyRun, stops_in_a_pilot_when_asked_to) {
  const StopSignal stop{StopRequest::cancel};
  const TaskOutcome outcome = run_request(spec_of("f1_m", 0.1), toy_factory(), {}, stop);
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::CANCELLED);
}

}  // namespace
}  // namespace granary::run
