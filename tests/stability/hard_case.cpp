#include "tests/stability/hard_case.h"

#include <atomic>

#include "tests/support/slowdown.h"
#include "worker/run/cost_clock.h"
#include "worker/run/run_task.h"
#include "worker/run/task_setup.h"
#include "worker/scene/chute.h"
#include "worker/scene/discharge.h"

namespace granary::stability {
namespace {

std::unique_ptr<core::Simulation> make_engine(const v1::Scene& scene, const core::State* filling) {
  if (scene.has_discharge()) return scene::make_discharge(scene, filling);
  return scene::make_chute(scene, filling);
}

run::SimulationFactory factory_of(const HardCase& hard_case) {
  if (!hard_case.meddling) return make_engine;
  const auto done = std::make_shared<std::uint64_t>(0);
  return [&hard_case, done](const v1::Scene& scene, const core::State* filling) {
    return std::make_unique<testing::MeddledSimulation>(make_engine(scene, filling),
                                                        *hard_case.meddling, done);
  };
}

CaseOutcome refused(const std::string& message) {
  CaseOutcome outcome;
  outcome.end = End::refused;
  outcome.message = message;
  return outcome;
}

std::string evidence_of(const v1::Result& result) {
  std::string text;
  for (const v1::Decision& decision : result.decisions())
    if (decision.chosen_by() == "recovery")
      text += decision.path() + " = " + decision.value() + ": " + decision.evidence() + "; ";
  return text;
}

CaseOutcome outcome_of(const run::TaskOutcome& task) {
  CaseOutcome outcome;
  outcome.result = task.result;
  outcome.message = task.message;
  switch (task.outcome) {
    case v1::TaskFinished::COMPLETE:
      outcome.message = evidence_of(task.result);
      outcome.end = outcome.message.empty() ? End::complete : End::recovered;
      return outcome;
    case v1::TaskFinished::UNSTABLE:
      outcome.end = End::unstable;
      return outcome;
    case v1::TaskFinished::ERROR:  // a factory that refuses the scene
      outcome.end = End::refused;
      return outcome;
    default:
      outcome.failed = true;
      return outcome;
  }
}

}  // namespace

std::string to_string(End end) {
  switch (end) {
    case End::complete:
      return "complete";
    case End::recovered:
      return "recovered";
    case End::unstable:
      return "unstable";
    case End::refused:
      return "refused";
  }
  return "";
}

CaseOutcome run_case(const HardCase& hard_case) {
  const run::CostTimer timer;
  const Result<v1::Scene> scene =
      load_scene(hard_case.scene, hard_case.name + ".txtpb", hard_case.settings);
  if (!scene) return refused(scene.error().message);
  const run::SimulationFactory factory = factory_of(hard_case);
  Result<run::TaskSpec> spec = run::make_task(*scene, {factory, "portable"});
  if (!spec) return refused(spec.error().message);
  spec->time_limit_s = kHangSeconds * test::kSlowdown;
  const run::StopSignal stop{run::StopRequest::none};
  CaseOutcome outcome = outcome_of(run::run_task(*spec, factory, {}, stop));
  outcome.seconds = timer.cpu_s();
  return outcome;
}

}  // namespace granary::stability
