// Claim: a rotating chute gives the same means in its own frame and in the laboratory's.
// Method: a short narrow chute at 40 rpm, 3 replicates per frame; corotating runs on the block
// engine,
//   turning walls on the plain one.
// Reference: each other. Paths of single grains: tests/physics/frames, 1e-6.
// Tolerance: the sum of both 95 % intervals over replicates (Student, 2 degrees of freedom).
// Seconds: 4
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/shipped_scenes.h"
#include "worker/core/student_t.h"
#include "worker/scene/chute.h"

namespace granary::tests {
namespace {

constexpr const char* kValues[] = {"particle_count", "exit_speed_m_per_s", "mass_flow_kg_per_s"};

// samples[value][replicate]
std::vector<std::vector<double>> replicates(const char* frame) {
  std::vector<std::vector<double>> samples(std::size(kValues));
  for (const char* seed : {"1", "2", "3"}) {
    const auto run =
        scene::make_chute(shipped_scene("chute_small", {{"chute.frame", frame},
                                                        {"chute.rotation_rpm", "40"},
                                                        {"chute.length_m", "0.08"},
                                                        {"chute.width_m", "0.02"},
                                                        {"chute.inlet.mass_flow_kg_per_s", "0.1"},
                                                        {"chute.duration_s", "0.3"},
                                                        {"chute.sample_start_s", "0.15"},
                                                        {"seed", seed}}));
    EXPECT_EQ(run->advance(1, 1'000'000).status, core::AdvanceStatus::finished);
    for (const core::ObservedValue& value : run->observe().values) {
      for (std::size_t k = 0; k < std::size(kValues); ++k) {
        if (value.name == kValues[k]) samples[k].push_back(value.value.value());
      }
    }
  }
  return samples;
}

TEST(ChuteFrames, give_the_same_means) {
  const auto turning = replicates("COROTATING");
  const auto laboratory = replicates("INERTIAL");
  for (std::size_t k = 0; k < std::size(kValues); ++k) {
    const auto a = core::mean_with_interval(turning[k]);
    const auto b = core::mean_with_interval(laboratory[k]);
    EXPECT_NEAR(a->mean, b->mean, a->half_width + b->half_width) << kValues[k];
    EXPECT_LT(a->half_width + b->half_width, 0.1 * a->mean) << kValues[k];
  }
}

}  // namespace
}  // namespace granary::tests
