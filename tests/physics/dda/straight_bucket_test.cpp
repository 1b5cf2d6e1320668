// Claim: the 700- and 4000-disk straight buckets discharge as the independent prototype did.
// Method: the shipped scenes, run as shipped; every disk watched at every step.
// Reference: PHYSICS section E, expected ranges (over dt, two integrators and an explicit DEM).
// Tolerance: those ranges, widened by 2.5 standard deviations of a mean of three seeds: 700 disks
// (one
//   run: f1 0.008 m, half gone 1.5 deg; measured over six seeds); 4000 disks (one run, section E:
//   f1, f2 0.3 %, f3 0.6 points; f4 0.7 % over twelve seeds, whose mean is 1.431 m). Gravity table:
//   3 points (one run 1.4 points over six seeds, and the table itself is one run). One disk may
//   stay in the 700-disk bucket: in the 45 deg wedge of its foot a disk locks itself between the
//   walls, because half the angle is below the wall friction of 34 deg.
// Seconds: 8
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
#include "worker/scene/discharge.h"
#include "worker/scene/discharge_simulation.h"

namespace granary::scene {
namespace {

struct Discharged {
  std::map<std::string, double> values;
  std::vector<double> remaining;  // per degree
  double worst_overlap = 0;       // of the smallest radius, over all steps
};

std::unique_ptr<core::Simulation> load(const std::string& name, std::uint64_t seed) {
  std::ifstream file(std::string(GRANARY_SCENES) + "/" + name + ".txtpb");
  std::stringstream text;
  text << file.rdbuf();
  const auto scene =
      load_scene(text.str(), name, std::array{FieldSetting{"seed", std::to_string(seed)}});
  EXPECT_TRUE(scene.ok());
  return make_discharge(resolve(*scene)->scene);
}

Discharged run_scene(const std::string& name, std::uint64_t seed = 1) {
  const auto simulation = load(name, seed);
  const auto& engine = static_cast<const DischargeSimulation&>(*simulation);
  Discharged run;
  while (simulation->advance(1e9, 1).status == core::AdvanceStatus::advanced) {
    double smallest = 1;
    for (std::size_t k = 0; k < engine.system().disks.count(); ++k)
      smallest = std::min(smallest, engine.system().disks.pose[k].radius);
    run.worst_overlap =
        std::max(run.worst_overlap, engine.system().report.worst_overlap / smallest);
  }
  const core::Observation seen = simulation->observe();
  for (const auto& value : seen.values)
    if (value.value) run.values[value.name] = *value.value;
  const auto remaining = seen.series[0].columns[2].as<double>();
  run.remaining.assign(remaining.begin(), remaining.end());
  EXPECT_LT(simulation->ledger().remainder_ratio(), 1e-3);
  return run;
}

TEST(StraightBucket, of_700_disks_empties_centrifugally) {
  double f1 = 0, half_gone = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Discharged run = run_scene("discharge_700_centrifugal", seed);
    f1 += run.values.at("f1_m") / 3;
    half_gone += run.values.at("a50_deg") / 3;
    EXPECT_LE(run.values.at("f3_percent"), 100.0 / run.values.at("count_initial") + 1e-9);
    EXPECT_LT(run.worst_overlap, 0.15);
  }
  EXPECT_GE(f1, 0.94 - 0.012);
  EXPECT_LE(f1, 0.98 + 0.012);
  EXPECT_GE(half_gone, 55 - 2.2);
  EXPECT_LE(half_gone, 59 + 2.2);
}

TEST(StraightBucket, of_700_disks_empties_by_gravity) {
  std::map<int, double> remaining;
  const std::map<int, double> expected = {{60, 93},  {80, 73},  {90, 63}, {100, 51}, {110, 40},
                                          {120, 29}, {130, 16}, {140, 5}, {150, 0}};
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Discharged run = run_scene("discharge_700_gravity", seed);
    EXPECT_LT(run.worst_overlap, 0.15);
    for (const auto& [degree, percent] : expected)
      remaining[degree] += run.remaining.at(static_cast<std::size_t>(degree)) / 3;
  }
  for (const auto& [degree, percent] : expected)
    EXPECT_NEAR(remaining[degree], percent, 3) << degree;
}

TEST(StraightBucket, of_4000_disks_throws_as_far_as_the_prototype) {
  std::map<std::string, double> mean;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Discharged run = run_scene("discharge_4000_straight", seed);
    EXPECT_LT(run.worst_overlap, 0.2);
    for (const char* name : {"f1_m", "f2_m", "f3_percent", "f4_m"})
      mean[name] += run.values.at(name) / 3;
  }
  const double widening = 2.5 / std::sqrt(3.0);
  EXPECT_GE(mean["f1_m"], 1.92 * (1 - 0.003 * widening));
  EXPECT_LE(mean["f1_m"], 1.96 * (1 + 0.003 * widening));
  EXPECT_GE(mean["f2_m"], 2.04 * (1 - 0.003 * widening));
  EXPECT_LE(mean["f2_m"], 2.09 * (1 + 0.003 * widening));
  EXPECT_GE(mean["f3_percent"], 3.3 - 0.6 * widening);
  EXPECT_LE(mean["f3_percent"], 6.3 + 0.6 * widening);
  EXPECT_GE(mean["f4_m"], 1.40 * (1 - 0.007 * widening));
  EXPECT_LE(mean["f4_m"], 1.44 * (1 + 0.007 * widening));
}

}  // namespace
}  // namespace granary::scene
