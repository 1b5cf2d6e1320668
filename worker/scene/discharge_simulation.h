// The scenario of a discharge over the DDA engine: filling -> (run-up) -> rotation -> landing.
// Whatever was filled passes through the same stored-filling state, whether it was filled here or
// read, so that reuse changes no bit.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "worker/core/simulation.h"
#include "worker/dda/system.h"
#include "worker/scene/discharge_plan.h"
#include "worker/scene/discharge_record.h"

namespace granary::scene {

enum class DischargePhase : std::uint8_t { filling, run_up, rotation, landing, finished };
std::string_view to_string(DischargePhase phase);

class DischargeSimulation : public core::Simulation {
 public:
  DischargeSimulation(DischargePlan plan, const core::State* stored_filling);

  core::AdvanceOutcome advance(double until_time_s, std::uint64_t max_steps) override;
  core::SimulationProgress progress() const override;
  const core::EnergyLedger& ledger() const override { return system_.ledger; }
  core::Observation observe() const override;
  std::vector<core::ColumnView> frame() const override;
  std::vector<core::ColumnView> physical_state() const override;
  core::State snapshot() const override;
  void restore(const core::State& state) override;
  std::optional<core::State> stored_filling() const override { return filling_; }
  std::vector<core::PhaseSeconds> profile() const override;
  std::uint64_t steps_between_marks() const override;
  std::uint64_t unconverged_steps() const override;
  bool knows(core::Remedy remedy) const override;
  core::SettingChange apply(core::Remedy remedy) override;

  const dda::System& system() const { return system_; }
  DischargePhase phase() const { return phase_; }

 private:
  void choose_solver();
  void choose_books();  // of the phase
  void begin_filling();
  void end_filling();
  void begin_motion();
  void start_phase(DischargePhase phase, double start_time, double time_step);
  void after_step();
  void drop_spilled();
  void after_filling_step();
  void after_rotation_step();
  std::optional<core::Rejection> check_sentinels() const;
  double end_time() const;  // of the rotation
  double shown_time() const;
  double longest_run_up() const;
  bool has_landing() const;
  LandingLevels landing_levels() const;
  void note_flight();

  DischargePlan plan_;
  dda::System system_;
  DischargeRecord record_;
  DischargePhase phase_ = DischargePhase::filling;
  double phase_start_ = 0;  // system time at the start of the phase
  std::uint64_t phase_steps_ = 0;
  double peak_kinetic_energy_ = 0;  // of the filling
  std::optional<core::State> filling_;
  std::vector<std::uint8_t> flying_;         // scratch of note_flight
  mutable std::vector<core::Column> shown_;  // columns behind the last frame() or physical_state()
};

// Columns of the stored filling inside a checkpoint carry this prefix.
inline const std::string kFillingPrefix = "filling.";

// Disks inside the bucket and their contact forces, and back into a system.
core::State store_filling(const dda::System& system, const dda::BucketGeometry& bucket,
                          std::size_t placed_count, bool settled);
// Both throw std::runtime_error when a column is missing or of another shape.
void load_filling(const core::State& state, dda::System& system);
void load_system(const core::State& state, dda::System& system);
void load_record(const core::State& state, DischargeRecord& record);
void store_system(const dda::System& system, core::State& state);
void store_record(const DischargeRecord& record, core::State& state);

}  // namespace granary::scene
