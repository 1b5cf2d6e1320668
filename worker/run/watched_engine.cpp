#include "worker/run/watched_engine.h"

#include <stdexcept>
#include <utility>

#include "worker/run/cost_clock.h"
#include "worker/run/sentinels.h"

namespace granary::run {

WatchedEngine::WatchedEngine(std::unique_ptr<core::Simulation> simulation, RunCosts& costs)
    : simulation_(std::move(simulation)),
      costs_(costs),
      now_(simulation_->progress()),
      particle_steps_before_(now_.particle_steps),
      last_good_ledger_(simulation_->ledger()) {}

core::AdvanceStatus WatchedEngine::advance(double limit_s) {
  const CostTimer timer;
  const core::AdvanceOutcome outcome = simulation_->advance(limit_s, chunk_.steps());
  const std::uint64_t steps = book(timer.wall_s(), timer.cpu_s());
  if (outcome.status == core::AdvanceStatus::advanced && steps == 0)
    throw std::logic_error("the engine does not advance");
  if (outcome.status == core::AdvanceStatus::rejected) {
    rejection_ =
        outcome.rejection.value_or(core::Rejection{now_.time_s, "no reason given", {}, ""});
    return outcome.status;
  }
  return energies_are_finite() ? outcome.status : core::AdvanceStatus::rejected;
}

// Returns the steps of the chunk.
std::uint64_t WatchedEngine::book(double wall_s, double cpu_s) {
  costs_.engine_wall_s += wall_s;
  costs_.engine_cpu_s += cpu_s;
  const core::SimulationProgress before = std::exchange(now_, simulation_->progress());
  if (now_.particles > 0)
    costs_.contacts_per_particle_sum +=
        static_cast<double>(now_.particle_steps - before.particle_steps) *
        static_cast<double>(now_.contacts) / static_cast<double>(now_.particles);
  const std::uint64_t steps = now_.steps - before.steps;
  chunk_.note(steps, wall_s);
  return steps;
}

bool WatchedEngine::energies_are_finite() {
  if (ledger_is_finite(simulation_->ledger())) {
    last_good_ledger_ = simulation_->ledger();
    return true;
  }
  const auto where = find_non_finite(simulation_->physical_state());
  rejection_ = rejection_of(where.value_or(NonFinite{"an energy", 0}), now_.time_s);
  return false;
}

bool WatchedEngine::accepts(std::span<const core::ColumnView> columns) {
  const auto where = find_non_finite(columns);
  if (where) rejection_ = rejection_of(*where, now_.time_s);
  return !where;
}

}  // namespace granary::run
