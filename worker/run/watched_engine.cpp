#include "worker/run/watched_engine.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "worker/core/books.h"
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
  const std::uint64_t to_mark = next_mark_ > now_.steps ? next_mark_ - now_.steps : 1;
  const core::AdvanceOutcome outcome =
      simulation_->advance(limit_s, std::min(chunk_.steps(), to_mark));
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
  if constexpr (!core::kBooks) return true;
  const core::EnergyLedger ledger = simulation_->ledger();  // engines may have to add it up
  if (ledger_is_finite(ledger)) {
    last_good_ledger_ = ledger;
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

bool WatchedEngine::reject(std::optional<core::Rejection> rejection) {
  if (rejection) rejection_ = std::move(rejection);
  return !rejection_;
}

bool WatchedEngine::is_sound() {
  if constexpr (!core::kBooks) return true;
  if (!reject(convergence_rejection(simulation_->unconverged_steps() - mark_.unconverged_steps,
                                    now_.steps - mark_.steps, now_.time_s)))
    return false;
  return reject(energy_rejection(last_good_ledger_, now_.time_s));
}

void WatchedEngine::set_mark(const FrameSchedule::State& frames) {
  set_mark({now_.steps, simulation_->unconverged_steps(), now_.time_s,
            costs_.contacts_per_particle_sum, frames},
           simulation_->snapshot());
}

void WatchedEngine::set_mark(const Mark& mark, core::State state) {
  mark_ = mark;
  mark_state_ = std::move(state);
  next_mark_ = mark_.steps + std::max<std::uint64_t>(1, simulation_->steps_between_marks());
}

core::SettingChange WatchedEngine::go_back(core::Remedy remedy) {
  simulation_->restore(mark_state_);
  const core::SettingChange change = simulation_->apply(remedy);
  rejection_.reset();
  now_ = simulation_->progress();
  costs_.contacts_per_particle_sum = mark_.contacts_per_particle_sum;
  // The changed setting is part of the state that is gone back to next time.
  set_mark(mark_.frames);
  return change;
}

}  // namespace granary::run
