#include "worker/run/calibrate.h"

#include <algorithm>

#include "proto/contract/cost_model.h"

namespace granary::run {
namespace {

constexpr std::uint64_t kLeastParticleSteps = 1'000'000;

bool did_the_work(const TaskSpec& spec, const TaskOutcome& outcome) {
  const v1::Result& result = outcome.result;
  const bool recovered =
      std::any_of(result.decisions().begin(), result.decisions().end(),
                  [](const v1::Decision& d) { return d.chosen_by() == "recovery"; });
  return outcome.outcome == v1::TaskFinished::COMPLETE && !recovered &&
         !spec.scene.has_accuracy() && spec.scene.threads() <= 1 && result.cost().reused_s() == 0 &&
         result.cost().particle_steps() >= kLeastParticleSteps;
}

}  // namespace

void note_speed(const TaskSpec& spec, const TaskOutcome& outcome) {
  if (!did_the_work(spec, outcome)) return;
  const CostEstimate shipped = predict_cost(spec.scene, Calibration());
  Calibration calibration = Calibration::load();
  calibration.note(shipped.engine, outcome.result.cost().cpu_s() / shipped.cpu_s.value);
  calibration.save();
}

}  // namespace granary::run
