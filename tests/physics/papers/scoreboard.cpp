#include "tests/physics/papers/scoreboard.h"

#include <cmath>
#include <cstdio>

#include "tests/support/shipped_scenes.h"

namespace granary::tests {

scene::DischargePlan plan_of(const std::string& name,
                             const std::vector<std::pair<std::string, std::string>>& settings) {
  return scene::make_discharge_plan(shipped_scene(name, settings));
}

std::vector<DischargeRun> runs_of(const std::string& name,
                                  const std::vector<std::pair<std::string, std::string>>& settings,
                                  int fillings) {
  std::vector<DischargeRun> runs;
  for (int seed = 1; seed <= fillings; ++seed) {
    auto seeded = settings;
    seeded.emplace_back("seed", std::to_string(seed));
    runs.push_back(run_discharge(plan_of(name, seeded)));
  }
  return runs;
}

double angle_of_percent_left(const DischargeRun& run, double percent) {
  for (std::size_t k = 1; k < run.remaining.size(); ++k) {
    const double before = run.remaining[k - 1], now = run.remaining[k], level = 100 - percent;
    if (now > level) continue;
    return static_cast<double>(k - 1) + (before > now ? (before - level) / (before - now) : 0);
  }
  return NAN;
}

Sample value_over(const std::vector<DischargeRun>& runs, const std::string& name) {
  return over(runs, [&](const DischargeRun& run) { return run.values.at(name); });
}

std::string text(double value, int digits) {
  if (std::isnan(value)) return "never";
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
  return buffer;
}

std::string text(const Sample& sample, int digits) {
  if (std::isnan(sample.error)) return text(sample.mean, digits);
  return text(sample.mean, digits) + " +- " + text(sample.error, digits);
}

Verdict judge(bool holds) {
  return holds ? Verdict::agrees : Verdict::differs;
}

}  // namespace granary::tests
