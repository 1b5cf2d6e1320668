// Claim: 95 % intervals hold what they say: at least 90 % of those of small scenes contain the fine
//   reference, and of no observable significantly fewer than 95 %.
// Method: thirty runs of four replicates, all with other seeds, through `granary-worker --scene`;
// of a
//   bucket of 50 disks and of a chute of 400 grains. Shipped scenes, accuracy targets, every part
//   of the error: tests/accuracy/coverage.py (tests/long.sh coverage).
// Reference: mean of many more replicates with half the time step, its own interval included.
// Tolerance: contained when |value - reference| <= hypot(error, reference error), which two correct
//   95 % intervals of independent normal means do in 95 % of all cases. Of 30 such, more than 6
//   fail with probability 6e-4 (binomial); with a true coverage of 75 % they do with 0.65, of 60 %
//   with 0.98. Seeds are fixed, so the outcome is too.
// Seconds: 12
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace granary::test {
namespace {

constexpr int kIntervals = 30, kReplicates = 4;
constexpr int kMostMisses = 6;
constexpr double kLeastCoverage = 0.9;

struct Case {
  std::string scene;
  std::vector<std::string> settings;
  std::string half_step;
  int reference_replicates;
  std::vector<std::string> observables;
};

const Case kBucket{"discharge_small",
                   {"discharge.particles.count=50", "discharge.bucket.tip_x_m=-0.04",
                    "discharge.bucket.tip_y_m=0.04"},
                   "discharge.time_step_s=1e-4",
                   150,
                   {"f1_m", "f2_m", "f4_m", "a50_deg"}};
const Case kChute{"chute_small",
                  {"chute.duration_s=0.16", "chute.length_m=0.05", "chute.sample_start_s=0.08",
                   "chute.width_m=0.04", "chute.inlet.mass_flow_kg_per_s=0.2",
                   "chute.inlet.sluice_height_m=0.0075"},
                  "chute.time_step_s=5e-6",
                  40,
                  {"exit_speed_m_per_s", "mass_flow_kg_per_s"}};

nlohmann::json values_of(const Case& example, std::vector<std::string> more) {
  std::vector<std::string> command = {GRANARY_BIN "/granary-worker",
                                      "--scene",
                                      GRANARY_SCENES "/" + example.scene + ".txtpb",
                                      "-q",
                                      "--format",
                                      "json"};
  more.insert(more.end(), example.settings.begin(), example.settings.end());
  for (const std::string& setting : more) command.insert(command.end(), {"--set", setting});
  Program worker({.command = command, .environment = {}, .input = ""});
  EXPECT_EQ(worker.wait(std::chrono::seconds(200)), 0) << worker.err();
  worker.collect_output();
  return nlohmann::json::parse(worker.out())["values"];
}

class Coverage : public testing::TestWithParam<Case> {};

TEST_P(Coverage, intervals_hold_the_fine_reference) {
  const Case& example = GetParam();
  const nlohmann::json reference = values_of(
      example, {example.half_step, "replicates=" + std::to_string(example.reference_replicates)});
  std::map<std::string, int> misses;
  for (int k = 0; k < kIntervals; ++k) {
    const nlohmann::json values = values_of(example, {"seed=" + std::to_string(1000 * (k + 1)),
                                                      "replicates=" + std::to_string(kReplicates)});
    for (const std::string& name : example.observables) {
      const double off =
          values[name]["value"].get<double>() - reference[name]["value"].get<double>();
      const double error =
          std::hypot(values[name]["error"].get<double>(), reference[name]["error"].get<double>());
      misses[name] += std::abs(off) <= error ? 0 : 1;
    }
  }
  int all = 0;
  for (const auto& [name, count] : misses) {
    EXPECT_LE(count, kMostMisses) << name << ": of " << kIntervals;
    RecordProperty(name + "_misses", count);
    all += count;
  }
  const double intervals = kIntervals * static_cast<double>(example.observables.size());
  EXPECT_GE(1 - all / intervals, kLeastCoverage) << all << " misses of " << intervals;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Coverage, testing::Values(kBucket, kChute),
                         [](const auto& info) { return info.param.scene; });

}  // namespace
}  // namespace granary::test
