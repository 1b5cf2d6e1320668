// A simulation that somebody meddles with: at given steps its state is changed from outside - a
// NaN, a push that no force explains - as a bug or a bad memory cell would. Everything else passes
// through.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "worker/core/simulation.h"

namespace granary::testing {

struct Meddling {
  std::uint64_t first_step = 0;
  std::uint64_t interval = 0;  // steps between two interventions; 0 = only one
  std::uint64_t count = 1;     // interventions, going back included
  std::function<void(core::State&)> change;
};

class MeddledSimulation : public core::Simulation {
 public:
  // `done` counts interventions over all simulations of a run, so that going back does not undo it.
  MeddledSimulation(std::unique_ptr<core::Simulation> inner, Meddling meddling,
                    std::shared_ptr<std::uint64_t> done);

  core::AdvanceOutcome advance(double until_time_s, std::uint64_t max_steps) override;
  core::SimulationProgress progress() const override { return inner_->progress(); }
  const core::EnergyLedger& ledger() const override { return inner_->ledger(); }
  core::Observation observe() const override { return inner_->observe(); }
  std::vector<core::ColumnView> frame() const override { return inner_->frame(); }
  std::vector<core::ColumnView> physical_state() const override { return inner_->physical_state(); }
  core::State snapshot() const override { return inner_->snapshot(); }
  void restore(const core::State& state) override { inner_->restore(state); }
  std::uint64_t steps_between_marks() const override { return inner_->steps_between_marks(); }
  std::uint64_t unconverged_steps() const override { return inner_->unconverged_steps(); }
  bool knows(core::Remedy remedy) const override { return inner_->knows(remedy); }
  core::SettingChange apply(core::Remedy remedy) override { return inner_->apply(remedy); }

 private:
  std::uint64_t next_step() const { return meddling_.first_step + *done_ * meddling_.interval; }

  std::unique_ptr<core::Simulation> inner_;
  Meddling meddling_;
  std::shared_ptr<std::uint64_t> done_;
};

// Changes of the first particle's velocity, in the snapshots of either engine.
std::function<void(core::State&)> velocity_becomes_nan();
std::function<void(core::State&)> velocity_jumps_by(double along_y_m_per_s);

}  // namespace granary::testing
