// Runs discharge scenes in this process and prints what they cost and what they give: CPU seconds
// of filling, rotation and landing, the profile, f1..f4, the worst overlap and the ledger.
// Usage: discharge_run SCENE [path=value ..]
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <sstream>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
#include "worker/scene/discharge.h"
#include "worker/scene/discharge_simulation.h"

namespace {

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

granary::v1::Scene read_scene(int argc, char** argv) {
  std::ifstream file(argv[1]);
  std::stringstream text;
  text << file.rdbuf();
  std::vector<granary::FieldSetting> settings;
  for (int k = 2; k < argc; ++k) {
    const std::string setting = argv[k];
    const auto equals = setting.find('=');
    settings.emplace_back(setting.substr(0, equals), setting.substr(equals + 1));
  }
  const auto scene = granary::load_scene(text.str(), argv[1], settings);
  if (!scene) std::cerr << scene.error().message << "\n", std::exit(2);
  const auto resolved = granary::resolve(*scene);
  if (!resolved) std::cerr << resolved.error().message << "\n", std::exit(2);
  return resolved->scene;
}

}  // namespace

int main(int argc, char** argv) {
  using granary::scene::DischargeSimulation;
  const granary::v1::Scene scene = read_scene(argc, argv);
  const auto simulation = granary::scene::make_discharge(scene);
  const auto& engine = static_cast<const DischargeSimulation&>(*simulation);
  std::string phase;
  double phase_start = cpu_seconds(), worst = 0;
  std::uint64_t start_steps = 0, start_sweeps = 0, start_updates = 0;
  const auto close_phase = [&] {
    const auto& c = engine.system().counters;
    std::printf(
        "%-9s %8.3f s CPU %6lu steps  %5.1f sweeps/step  %8.0f contacts/sweep  worst overlap %.3f "
        "r\n",
        phase.c_str(), cpu_seconds() - phase_start, c.steps - start_steps,
        double(c.sweeps - start_sweeps) / double(c.steps - start_steps),
        double(c.contact_updates - start_updates) / double(c.sweeps - start_sweeps),
        worst / engine.system().disks.pose[0].radius);
    std::printf(
        "          %lu list rebuilds, %zu pair candidates, %zu wall candidates, %zu contacts\n",
        engine.system().lists.rebuild_count(), engine.system().lists.pairs.size(),
        engine.system().lists.walls.size(), engine.system().report.contacts);
    phase_start = cpu_seconds(), start_steps = c.steps, start_sweeps = c.sweeps;
    start_updates = c.contact_updates, worst = 0;
  };
  for (;;) {
    const auto outcome = simulation->advance(1e9, 1);
    const std::string now(to_string(engine.phase()));
    worst = std::max(worst, engine.system().report.worst_overlap);
    if (outcome.rejection) std::printf("rejected: %s\n", outcome.rejection->reason.c_str());
    if (now != phase) {
      if (!phase.empty()) close_phase();
      phase = now;
    }
    if (outcome.status != granary::core::AdvanceStatus::advanced) break;
  }
  for (const auto& part : simulation->profile())
    std::printf("  %-16s %8.3f s\n", part.phase.c_str(), part.seconds);
  const auto seen = simulation->observe();
  for (const auto& value : seen.values)
    std::printf("%s %.5g  ", value.name.c_str(), value.value.value_or(NAN));
  std::printf("\n");
  for (const auto& table : seen.series)
    if (table.name == "remaining")
      for (std::size_t d = 0; d < table.columns[1].rows; d += 10)
        std::printf("%zu:%.1f ", d, table.columns[2].as<double>()[d]);
  std::printf("\n");
  for (const auto& warning : seen.warnings) std::printf("warning: %s\n", warning.c_str());
  const auto& ledger = simulation->ledger();
  std::printf("ledger: kinetic %.4g potential %.4g elastic %.4g throughput %.4g remainder %.3g\n",
              ledger.kinetic_j, ledger.potential_j, ledger.elastic_j, ledger.throughput_j,
              ledger.remainder_ratio());
  for (std::size_t k = 0; k < granary::core::kEnergyChannelCount; ++k)
    if (ledger.channels_j[k] != 0)
      std::printf("  %s %.4g",
                  std::string(to_string(static_cast<granary::core::EnergyChannel>(k))).c_str(),
                  ledger.channels_j[k]);
  std::printf("\nhash %s\n", granary::core::hash_columns(simulation->physical_state()).c_str());
}
