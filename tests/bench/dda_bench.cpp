// The DDA engine by the step (Google Benchmark): what a contact update costs, all phases included,
// against the number of disks, the solver and the contact laws.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
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

}  // namespace
}  // namespace granary::scene
