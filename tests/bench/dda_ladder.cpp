// Independence of a discharge from the step and the penalty: f1..f4 over K and dt at the scene's
// restitution, each a mean over fillings with its 95 % interval, and the difference to the limit of
// small steps (K 1e7, dt 5e-5, K h^2 / m <= 0.06, tolerance 0.05). Prints a markdown table.
// Usage: dda_ladder SCENE FILLINGS [path=value ..]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "proto/contract/version.h"
#include "tests/physics/papers/scoreboard.h"

namespace {

using namespace granary::tests;
using Settings = std::vector<std::pair<std::string, std::string>>;

struct Rung {
  std::string stiffness, time_step;
  bool limit = false;  // of small steps
};

struct Outcome {
  Sample f1, f2, f3, f4;
  double cpu_s = 0;  // of one run, filling included
};

Outcome run_rung(const std::string& scene, const Settings& common, const Rung& rung, int fillings) {
  std::vector<DischargeRun> runs;
  const std::clock_t start = std::clock();
  for (int seed = 1; seed <= fillings; ++seed) {
    Settings settings = common;
    settings.emplace_back("seed", std::to_string(seed));
    settings.emplace_back("discharge.penalty.stiffness_n_per_m", rung.stiffness);
    settings.emplace_back("discharge.time_step_s", rung.time_step);
    if (rung.limit) settings.emplace_back("discharge.solver.tolerance", "0.05");
    granary::scene::DischargePlan plan = plan_of(scene, settings);
    if (rung.limit) plan.solver.small_step_kappa = 0.06;
    runs.push_back(run_discharge(plan));
  }
  return {value_over(runs, "f1_m"), value_over(runs, "f2_m"), value_over(runs, "f3_percent"),
          value_over(runs, "f4_m"), double(std::clock() - start) / CLOCKS_PER_SEC / fillings};
}

// "+0.3 +- 0.5" in percent of the limit, or in points.
std::string difference(const Sample& value, const Sample& limit, bool points) {
  const double scale = points ? 1 : 100 / limit.mean;
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%+.1f +- %.1f", scale * (value.mean - limit.mean),
                scale * std::hypot(value.error, limit.error));
  return buffer;
}

bool within(const Sample& value, const Sample& limit, double margin) {
  return std::abs(value.mean - limit.mean) <= margin;
}

void print(const Rung& rung, const Outcome& o, const Outcome& limit) {
  const bool holds = within(o.f1, limit.f1, 0.01 * limit.f1.mean) &&
                     within(o.f2, limit.f2, 0.01 * limit.f2.mean) && within(o.f3, limit.f3, 1.5) &&
                     within(o.f4, limit.f4, 0.02 * limit.f4.mean);
  std::printf("| %s | %s%s | %s | %s | %s | %s | %s | %s | %s | %s | %.2f | %s |\n",
              rung.stiffness.c_str(), rung.time_step.c_str(), rung.limit ? " (limit)" : "",
              text(o.f1, 3).c_str(), text(o.f2, 3).c_str(), text(o.f3, 2).c_str(),
              text(o.f4, 3).c_str(), difference(o.f1, limit.f1, false).c_str(),
              difference(o.f2, limit.f2, false).c_str(), difference(o.f3, limit.f3, true).c_str(),
              difference(o.f4, limit.f4, false).c_str(), o.cpu_s, holds ? "yes" : "**no**");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::string scene = argv[1];
  const int fillings = std::atoi(argv[2]);
  Settings common;
  for (int k = 3; k < argc; ++k) {
    const std::string setting = argv[k];
    const auto equals = setting.find('=');
    common.emplace_back(setting.substr(0, equals), setting.substr(equals + 1));
  }
  std::printf("`%s`, engine %s, %d fillings\n\n", scene.c_str(), granary::kEngineVersion, fillings);
  std::printf(
      "| K N/m | dt s | f1 m | f2 m | f3 %% | f4 m | df1 %% | df2 %% | df3 points | df4 %% | "
      "CPU s | within |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | "
      "--- |\n");
  const Rung limit_rung{"1e7", "5e-5", true};
  const Outcome limit = run_rung(scene, common, limit_rung, fillings);
  print(limit_rung, limit, limit);
  for (const std::string stiffness : {"1e6", "1e7", "1e8"})
    for (const std::string time_step : {"5e-5", "1e-4", "2e-4"}) {
      const Rung rung{stiffness, time_step};
      print(rung, run_rung(scene, common, rung, fillings), limit);
    }
}
