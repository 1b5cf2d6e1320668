// One simulation under watch: advanced in chunks of about 50 ms that end at its marks, its price
// booked, and its state checked after each chunk and more closely at marks, so that nothing that is
// no number gets any further.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "worker/core/simulation.h"
#include "worker/run/pacing.h"
#include "worker/run/recovery.h"
#include "worker/run/run_record.h"

namespace granary::run {

class WatchedEngine {
 public:
  // Engine seconds and contacts are added to `costs`, which outlives this.
  WatchedEngine(std::unique_ptr<core::Simulation> simulation, RunCosts& costs);

  // Not beyond `limit_s` of simulated time, nor beyond the next mark. Throws std::logic_error when
  // the engine makes no step.
  core::AdvanceStatus advance(double limit_s);

  bool at_mark() const { return now_.steps == mark_.steps; }
  bool mark_due() const { return now_.steps >= next_mark_; }
  const Mark& mark() const { return mark_; }
  // The sentinels' verdict on what happened since the last mark; false sets rejection().
  bool is_sound();
  // The present state becomes the last mark; a resumed run brings its own.
  void set_mark(const FrameSchedule::State& frames);
  void set_mark(const Mark& mark, core::State state);
  const core::State& mark_state() const { return mark_state_; }

  // Back to the mark, with one setting changed. Precondition: the simulation knows the remedy.
  core::SettingChange go_back(core::Remedy remedy);

  // The sentinels' verdict on these columns; false sets rejection().
  bool accepts(std::span<const core::ColumnView> columns);

  core::Simulation& simulation() { return *simulation_; }
  const core::SimulationProgress& now() const { return now_; }  // asking the engine is not free
  const std::optional<core::Rejection>& rejection() const { return rejection_; }
  const core::EnergyLedger& last_good_ledger() const { return last_good_ledger_; }
  std::uint64_t new_particle_steps() const { return now_.particle_steps - particle_steps_before_; }

 private:
  std::uint64_t book(double wall_s, double cpu_s);
  bool energies_are_finite();
  bool reject(std::optional<core::Rejection> rejection);

  std::unique_ptr<core::Simulation> simulation_;
  RunCosts& costs_;
  core::SimulationProgress now_;
  std::uint64_t particle_steps_before_;  // done in earlier attempts
  ChunkPacer chunk_;
  std::optional<core::Rejection> rejection_;
  core::EnergyLedger last_good_ledger_;
  Mark mark_;
  core::State mark_state_;
  std::uint64_t next_mark_ = 0;
};

}  // namespace granary::run
