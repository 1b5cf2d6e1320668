// A small engine with everything a real one has: a chain of masses and springs, shaken at random
// times, with a filling at negative time, frames, series, fields, a ledger and full snapshots. Its
// knobs make it slow, sick or stubborn on demand. Knobs ride in the scene's name: "toy spin_us=20
// reject_at_step=500", so that they reach an engine process as well.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "granary/v1/scene.pb.h"
#include "worker/core/simulation.h"
#include "worker/run/task.h"

namespace granary::testing {

struct ToyOptions {
  static constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();
  std::size_t count = 8;
  double time_step_s = 1e-3;
  double duration_s = 1;
  double filling_s = 0.1;
  std::uint64_t seed = 1;
  std::uint64_t spin_us = 0;  // busy time per step
  std::uint64_t nan_at_step = kNever;
  std::uint64_t reject_at_step = kNever;
  std::uint64_t crash_at_step = kNever;  // abort()
  bool nan_value = false;                // f1_m comes out as NaN
  bool stuck = false;                    // never makes a step
};

ToyOptions toy_options(const v1::Scene& scene);

// discharge.particles.count, time_step_s, duration_s and seed decide it; valid for resolve().
v1::Scene toy_scene(const std::string& knobs = "");

class ToySimulation : public core::Simulation {
 public:
  explicit ToySimulation(const ToyOptions& options, const core::State* filling = nullptr);

  core::AdvanceOutcome advance(double until_time_s, std::uint64_t max_steps) override;
  core::SimulationProgress progress() const override;
  const core::EnergyLedger& ledger() const override { return ledger_; }
  core::Observation observe() const override;
  std::vector<core::ColumnView> frame() const override;
  std::vector<core::ColumnView> physical_state() const override;
  core::State snapshot() const override;
  void restore(const core::State& state) override;
  std::optional<core::State> stored_filling() const override;
  std::vector<core::PhaseSeconds> profile() const override;

 private:
  double time_s() const;
  void step();
  void shake();
  double energy_j() const;
  double spring_force(std::size_t i) const;

  ToyOptions options_;
  std::uint64_t filling_steps_;
  std::uint64_t steps_ = 0;
  std::vector<double> position_m_;
  std::vector<double> velocity_m_per_s_;
  std::vector<double> radius_m_;
  std::vector<std::int64_t> id_;
  std::vector<double> series_time_s_;
  std::vector<double> series_energy_j_;
  core::EnergyLedger ledger_;
  std::optional<core::State> filling_;
};

run::SimulationFactory toy_factory();

}  // namespace granary::testing
