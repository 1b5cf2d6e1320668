// The chute scenario: drives the DEM engine through filling, feed and sampling. What happens
// between steps (layers that enter or are set free, frames that are sampled) happens at step
// numbers fixed by the scene, so chunks and checkpoints cannot move it.
#pragma once

#include <memory>
#include <optional>

#include "worker/core/simulation.h"
#include "worker/dem/engine.h"
#include "worker/measure/hopper_record.h"
#include "worker/scene/chute_plan.h"

namespace granary::scene {

class ChuteSimulation final : public core::Simulation {
 public:
  // Throws std::runtime_error when the stored filling belongs to another scene.
  ChuteSimulation(ChutePlan plan, const core::State* stored_filling);

  core::AdvanceOutcome advance(double until_time_s, std::uint64_t max_steps) override;
  core::SimulationProgress progress() const override;
  const core::EnergyLedger& ledger() const override { return engine_->ledger(); }
  core::Observation observe() const override;
  std::vector<core::ColumnView> frame() const override;
  std::vector<core::ColumnView> physical_state() const override;
  core::State snapshot() const override;
  void restore(const core::State& state) override;
  std::optional<core::State> stored_filling() const override { return filling_; }
  std::vector<core::PhaseSeconds> profile() const override { return engine().profile(); }
  std::uint64_t steps_between_marks() const override;
  bool knows(core::Remedy remedy) const override;
  core::SettingChange apply(core::Remedy remedy) override;

 private:
  bool is_filling() const { return filling_engine_ != nullptr; }
  const dem::Engine& engine() const { return is_filling() ? *filling_engine_ : *engine_; }
  double now() const;  // negative while filling
  void advance_filling(double until_time, std::uint64_t max_steps);
  void begin_flow();
  void handle_events();
  void enter_layers();
  void free_layers();
  void sample();
  std::uint64_t next_event() const;
  std::uint64_t step_at(double time) const;
  double entry_time(std::int64_t layer) const;

  ChutePlan plan_;
  double filling_duration_ = 0;
  std::unique_ptr<dem::Engine> filling_engine_;
  std::optional<core::State> filling_;
  std::unique_ptr<dem::Engine> engine_;
  std::optional<dem::LatticeFeed> feed_;
  measure::ChuteObserver observer_;
  std::optional<measure::HopperRecord> hopper_;
  std::uint64_t filling_steps_ = 0;
  std::uint64_t filling_particle_steps_ = 0;
  std::uint64_t steps_not_made_ = 0;  // step numbers skipped when the time step was halved
  std::int64_t layers_entered_ = 0;
  std::int64_t layers_freed_ = 0;
  std::int64_t next_to_free_ = 0;  // id of the first grain still carried
  std::uint64_t frames_sampled_ = 0;
  mutable std::vector<core::Column> shown_;  // keeps the last frame's columns alive
};

}  // namespace granary::scene
