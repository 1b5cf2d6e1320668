// The DDA engine by the step (Google Benchmark): what a contact update costs, all phases included,
// against the number of disks and the contact laws; half a turn against an explicit integrator; a
// step against the open-close solver. --benchmark_filter chooses.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
#include "tests/bench/explicit_disks.h"
#include "worker/dda/step.h"
#include "worker/measure/discharge_values.h"
#include "worker/scene/discharge.h"
#include "worker/scene/discharge_simulation.h"

namespace granary::scene {
namespace {

// A bucket like that of discharge_4000_straight, as large as `count` disks of 3 mm need.
v1::Scene bed_scene(std::int64_t count, const std::vector<FieldSetting>& settings) {
  const double scale = std::sqrt(static_cast<double>(count) / 4000);
  const std::string size = std::to_string(0.4 * scale);
  const std::string text =
      "discharge { particles { count: " + std::to_string(count) +
      " diameter_min_m: 0.003 density_kg_per_m3: 2200 } bucket { tip_x_m: -" + size +
      " tip_y_m: " + size +
      " } friction_pp_deg: 40 friction_pw_deg: 40 pulley_radius_m: " + std::to_string(0.5 * scale) +
      " rotation_rad_per_s: " + std::to_string(10.5 / std::sqrt(scale)) + " } effects { gas: OFF }";
  return resolve(*load_scene(text, "bed", settings))->scene;
}

// Steps of a bed that is settling, `kSettled` steps after its rows were let go.
void measure_steps(benchmark::State& state, const v1::Scene& scene) {
  constexpr std::uint64_t kSettled = 300;
  const auto simulation = make_discharge(scene);
  const dda::System& system = static_cast<const DischargeSimulation&>(*simulation).system();
  simulation->advance(1e9, kSettled);
  const dda::StepCounters before = system.counters;
  for (auto _ : state) simulation->advance(1e9, 1);
  const auto updates =
      static_cast<double>(system.counters.contact_updates - before.contact_updates);
  const auto steps = static_cast<double>(system.counters.steps - before.steps);
  state.counters["per_update"] =
      benchmark::Counter(updates, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["updates_per_step"] = updates / steps;
  state.counters["contacts"] = static_cast<double>(system.report.contacts);
}

void settling_bed(benchmark::State& state) {
  measure_steps(state, bed_scene(state.range(0), {}));
}
BENCHMARK(settling_bed)
    ->Arg(700)
    ->Arg(4000)
    ->Arg(20000)
    ->Arg(100000)
    ->Iterations(40)
    ->Unit(benchmark::kMillisecond);

// The contact laws: what each adds to an update.
void contact_laws(benchmark::State& state) {
  const auto& effects = dda::kContactCombinations[state.range(0)];
  const auto mode = [](bool on) { return std::string(on ? "ON" : "OFF"); };
  measure_steps(state, bed_scene(4000, {{"effects.particle_rotation", mode(effects.rotation)},
                                        {"effects.tangential_history", mode(effects.history)},
                                        {"effects.cohesion", mode(effects.cohesion)},
                                        {"effects.rolling_friction", mode(effects.rolling)},
                                        {"discharge.cohesion_n_per_m", "0.1"},
                                        {"discharge.rolling_friction_coefficient", "0.1"}}));
}
BENCHMARK(contact_laws)
    ->DenseRange(0, dda::kCombinationCount - 1)
    ->Iterations(100)
    ->Unit(benchmark::kMillisecond);

// ---- half a turn of discharge_4000_straight, by the engine and by an explicit integrator

struct FilledBucket {
  DischargePlan plan;
  dda::System system;  // at the start of the rotation
};

const FilledBucket& filled_bucket() {
  static const FilledBucket bucket = [] {
    const DischargePlan plan = make_discharge_plan(bed_scene(4000, {}));
    DischargeSimulation simulation(plan, nullptr);
    while (simulation.phase() != DischargePhase::rotation) simulation.advance(1e9, 1);
    return FilledBucket{plan, simulation.system()};
  }();
  return bucket;
}

double end_time() {
  return filled_bucket().system.drive.half_turn_time() - 1e-9;
}

void report_flight(benchmark::State& state, const dda::System& system) {
  std::vector<measure::FlyingDisk> flying;
  for (std::size_t k = 0; k < system.disks.count(); ++k)
    if (!disk_in_bucket(system, *filled_bucket().plan.bucket, k))
      flying.push_back({system.disks.pose[k].x, system.disks.pose[k].y, system.mass[k]});
  const auto values = measure::flight_values(flying, system.disks.count());
  if (!values) return;
  state.counters["f1_m"] = values->centre_x;
  state.counters["f4_m"] = values->spread;
  state.counters["f3_percent"] =
      100 - 100.0 * static_cast<double>(flying.size()) / static_cast<double>(system.disks.count());
}

void half_turn_impulse(benchmark::State& state) {
  for (auto _ : state) {
    dda::System system = filled_bucket().system;
    while (system.time < end_time()) dda::step(system);
    report_flight(state, system);
  }
}
BENCHMARK(half_turn_impulse)->Iterations(1)->Repetitions(5)->Unit(benchmark::kMillisecond);

// Argument: steps per contact time t_c; below about 15 it gains energy.
void half_turn_explicit(benchmark::State& state) {
  for (auto _ : state) {
    dda::System system = filled_bucket().system;
    const double step = bench::contact_time_step(system, static_cast<double>(state.range(0)));
    while (system.time < end_time()) bench::explicit_step(system, step);
    report_flight(state, system);
  }
}
BENCHMARK(half_turn_explicit)
    ->Arg(20)
    ->Arg(42)
    ->Iterations(1)
    ->Repetitions(5)
    ->Unit(benchmark::kMillisecond);

// ---- one step in the middle of the discharge, by each solver, to the same tolerance of 1e-2

const dda::System& flowing_bed() {
  static const dda::System bed = [] {
    dda::System system = filled_bucket().system;
    while (system.time < end_time() / 3) dda::step(system);
    return system;
  }();
  return bed;
}

void measure_solver(benchmark::State& state, const dda::SolverSettings& solver, double time_step) {
  dda::System system = flowing_bed();
  system.solver = solver;
  system.time_step = time_step;
  dda::step(system);  // warm lists
  const dda::StepCounters before = system.counters;
  for (auto _ : state) dda::step(system);
  const auto steps = static_cast<double>(system.counters.steps - before.steps);
  state.counters["sweeps"] = static_cast<double>(system.counters.sweeps - before.sweeps) / steps;
  state.counters["iterations"] =
      static_cast<double>(system.counters.open_close_iterations - before.open_close_iterations) /
      steps;
  state.counters["unconverged"] =
      static_cast<double>(system.counters.unconverged_steps - before.unconverged_steps) / steps;
}

void step_small_steps(benchmark::State& state) {
  measure_solver(state, {.tolerance = 0.3}, 2e-4);
}
void step_sweeps(benchmark::State& state) {
  measure_solver(state, {.small_step_kappa = 0}, 1e-6 * static_cast<double>(state.range(0)));
}
void step_open_close_direct(benchmark::State& state) {
  measure_solver(state, {.method = dda::SolverMethod::open_close, .max_sweeps = 30},
                 1e-6 * static_cast<double>(state.range(0)));
}
void step_open_close_pcg(benchmark::State& state) {
  measure_solver(
      state,
      {.method = dda::SolverMethod::open_close, .linear = dda::LinearSolver::pcg, .max_sweeps = 30},
      1e-6 * static_cast<double>(state.range(0)));
}
BENCHMARK(step_small_steps)->Iterations(50)->Unit(benchmark::kMillisecond);
BENCHMARK(step_sweeps)->Arg(50)->Arg(200)->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(step_open_close_direct)->Arg(50)->Arg(200)->Iterations(5)->Unit(benchmark::kMillisecond);
BENCHMARK(step_open_close_pcg)->Arg(50)->Arg(200)->Iterations(5)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace granary::scene
