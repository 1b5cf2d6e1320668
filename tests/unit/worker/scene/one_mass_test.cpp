// Disks of one mass share the weights of their contacts; that saves memory traffic and changes
// nothing.
#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/shipped_scenes.h"
#include "worker/dda/step.h"
#include "worker/scene/discharge_simulation.h"

namespace granary::scene {
namespace {

template <typename Vector>
bool same_bits(const Vector& a, const Vector& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

TEST(OneMass, shared_weights_change_no_bit) {
  const DischargePlan plan = make_discharge_plan(
      tests::shipped_scene("discharge_4000_straight", {{"discharge.particles.count", "200"}}));
  DischargeSimulation simulation(plan, nullptr);
  while (simulation.phase() != DischargePhase::rotation) simulation.advance(1e9, 1);
  dda::System shared = simulation.system(), own = shared;
  ASSERT_TRUE(shared.one_mass);
  own.one_mass = false;
  for (int k = 0; k < 400; ++k) {
    dda::step(shared);
    dda::step(own);
  }
  EXPECT_GT(shared.report.contacts, 0u);
  EXPECT_TRUE(same_bits(shared.disks.motion, own.disks.motion));
  EXPECT_TRUE(same_bits(shared.disks.pose, own.disks.pose));
  EXPECT_EQ(shared.ledger.channels_j, own.ledger.channels_j);
}

TEST(OneMass, is_not_assumed_of_mixtures) {
  const DischargePlan plan =
      make_discharge_plan(tests::shipped_scene("discharge_small"));  // 3.5 to 4.5 mm
  DischargeSimulation simulation(plan, nullptr);
  simulation.advance(1e9, 1);
  EXPECT_FALSE(simulation.system().one_mass);
}

}  // namespace
}  // namespace granary::scene
