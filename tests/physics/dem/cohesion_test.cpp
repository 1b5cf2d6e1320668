// Claim: cohesion holds a bead to a wall exactly when it exceeds the weight, adds to the friction
// limit,
//   and has a potential: it costs no energy.
// Method: one bead under a ceiling; one bead that cannot turn on a slope; beads that stick
// together. Reference: balance of forces: hangs if and only if Bo > 1, slips beyond tan th = mu (1
// + Bo / cos th),
//   then a = g (sin th - mu (cos th + Bo)); PHYSICS section I.
// Tolerance: thresholds are bracketed by 5 %; acceleration 1e-3 (start-up of the tangential
// spring);
//   ledger: the attraction sets in at some point of a step, so each of two touches may be wrong by
//   F_c v dt.
// Seconds: < 0.5
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::tests {
namespace {

constexpr double kRadius = 0.0015;

dem::EngineSetup cohesive_setup(double bond) {
  dem::EngineSetup setup = base_setup(1e-5);
  setup.effects.cohesion = true;
  setup.grain_grain.cohesion_bond = setup.grain_wall.cohesion_bond = bond;
  setup.motion.gravity = {0, 0, -kGravity};
  return setup;
}

template <typename Engine>
class Cohesion : public ::testing::Test {};
TYPED_TEST_SUITE(Cohesion, DemEngines);

template <typename Engine>
double fall_under_ceiling(double bond) {
  dem::EngineSetup setup = cohesive_setup(bond);
  setup.walls = {{{0, 0, 0}, {0, 0, -1}}};
  Engine engine(setup);
  insert_one(engine, grain_at({0, 0, -kRadius + 1e-8}));
  engine.advance(10'000);
  return -kRadius - bead(engine).position.z;
}

TYPED_TEST(Cohesion, bead_hangs_where_cohesion_exceeds_its_weight) {
  EXPECT_LT(fall_under_ceiling<TypeParam>(1.05), 0);
  EXPECT_NEAR(fall_under_ceiling<TypeParam>(0.95), 0.5 * kGravity * 0.1 * 0.1, 0.02);
  EXPECT_GT(fall_under_ceiling<TypeParam>(0.95), 0.01);
}

// Two pairs fly at each other and stick; one pair turns. What dashpots take is all that is lost.
TYPED_TEST(Cohesion, attraction_costs_no_energy) {
  dem::EngineSetup setup = cohesive_setup(50);
  setup.motion.gravity = {0, 0, -1e-9};  // sets the scale of the bond only
  setup.grain_grain.cohesion_bond = 50 * kGravity / 1e-9;
  setup.grain_grain.normal_restitution = 0.5;
  TypeParam engine(setup);
  const std::vector<dem::Grain> pair = {grain_at({-0.00151, 0, 0}, {0.02, 0.03, 0}),
                                        grain_at({0.00151, 0, 0}, {-0.02, 0, 0})};
  engine.insert(pair);
  engine.advance(20'000);
  EXPECT_EQ(engine.contact_count(), 1U);
  EXPECT_GT(engine.effect_counts().cohesion, 0U);
  const double attraction = 50 * setup.classes[0].mass() * kGravity;
  EXPECT_LT(std::abs(engine.ledger().remainder_j()), 2 * attraction * 0.04 * setup.time_step);
  EXPECT_GT(engine.ledger()[core::EnergyChannel::normal_damping], 0);
}

TEST(CohesiveSlope, slips_beyond_the_raised_friction_limit) {
  const double theta = radians(30), limit = (std::tan(theta) / 0.22 - 1) * std::cos(theta);
  for (const double bond : {0.95 * limit, 1.05 * limit}) {
    dem::EngineSetup setup = cohesive_setup(bond);
    setup.effects.spin = false;
    setup.motion.gravity = gravity_on_slope(30);
    setup.walls = {floor_plane()};
    const auto engine = dem::make_engine(setup);
    const double weight = setup.classes[0].mass() * kGravity;
    insert_one(*engine, grain_at({0, 0, kRadius - weight * (std::cos(theta) + bond) / 1000}));
    engine->advance(10'000);
    const double early = bead(*engine).velocity.x;
    engine->advance(10'000);
    const double expected =
        std::max(0.0, kGravity * (std::sin(theta) - 0.22 * (std::cos(theta) + bond)));
    EXPECT_NEAR((bead(*engine).velocity.x - early) / 0.1, expected, 1e-3 * kGravity) << bond;
  }
}

}  // namespace
}  // namespace granary::tests
