#include "worker/scene/chute.h"

#include <stdexcept>

#include "worker/scene/chute_plan.h"
#include "worker/scene/chute_simulation.h"

namespace granary::scene {

std::unique_ptr<core::Simulation> make_chute(const v1::Scene& resolved,
                                             const core::State* stored_filling) {
  Result<ChutePlan> plan = plan_chute(resolved);
  if (!plan) throw std::invalid_argument(plan.error().message);
  return std::make_unique<ChuteSimulation>(std::move(*plan), stored_filling);
}

}  // namespace granary::scene
