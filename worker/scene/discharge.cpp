#include "worker/scene/discharge.h"

#include "worker/scene/discharge_plan.h"
#include "worker/scene/discharge_simulation.h"

namespace granary::scene {

std::unique_ptr<core::Simulation> make_discharge(const v1::Scene& resolved,
                                                 const core::State* stored_filling) {
  return std::make_unique<DischargeSimulation>(make_discharge_plan(resolved), stored_filling);
}

}  // namespace granary::scene
