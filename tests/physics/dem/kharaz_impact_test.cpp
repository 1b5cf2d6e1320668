// Claim: oblique impacts of a 5 mm alumina sphere follow the experiment of Kharaz as MFiX DEM05
// does. Method: 4000 kg/m3, 3.9 m/s, k_n 1.72e7, k_t 1.48e7, mu .092, undamped, on a wall; the
// angle is that
//   between the path and the normal of the wall.
// Reference: PHYSICS section A1, independent integration beside MFiX's linear model; exact in gross
//   slip: e_t = 1 - mu (1 + e_n) cot(angle), R w = 5/2 mu (1 + e_n) v_n.
// Tolerance: 1 % in gross slip (45 deg), 5 % in micro-slip (given there).
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::tests {
namespace {

template <typename Engine>
class KharazImpact : public ::testing::Test {};
TYPED_TEST_SUITE(KharazImpact, DemEngines);

constexpr double kSpeed = 3.9;

dem::EngineSetup alumina_setup() {
  dem::EngineSetup setup = base_setup(1);
  setup.classes = {dem::GrainClass{0.0025, 4000}};
  setup.grain_wall = {.normal_stiffness = 1.72e7,
                      .normal_restitution = 1,
                      .tangential_restitution = 1,
                      .friction = 0.092,
                      .rolling_friction = 0,
                      .tangential_stiffness = 1.48e7};
  setup.walls = {floor_plane()};
  setup.time_step = dem::collision_time(setup.grain_wall, setup.classes[0].mass()) / 1000;
  return setup;
}

struct Row {
  double angle, rebound_angle, spin, tangential_restitution, tolerance;
};

TYPED_TEST(KharazImpact, rebound_angle_spin_and_tangential_restitution) {
  const double exact_spin = 2.5 * 0.092 * 2 * kSpeed * std::cos(radians(45)) / 0.0025;
  for (const Row& row : {Row{5, 4.04, 65.8, .806, .05}, Row{10, 6.56, 235.8, .652, .05},
                         Row{20, 12.18, 542.7, .593, .05}, Row{45, 39.21, exact_spin, .816, .01}}) {
    const double tangential = kSpeed * std::sin(radians(row.angle));
    const Bead after = rebound<TypeParam>(alumina_setup(),
                                          {tangential, 0, -kSpeed * std::cos(radians(row.angle))});
    const double angle = std::atan2(after.velocity.x, after.velocity.z);
    EXPECT_NEAR(angle / radians(row.rebound_angle), 1, row.tolerance) << row.angle;
    EXPECT_NEAR(after.spin.y / row.spin, 1, row.tolerance) << row.angle;
    EXPECT_NEAR(after.velocity.x / tangential / row.tangential_restitution, 1, row.tolerance)
        << row.angle;
  }
}

}  // namespace
}  // namespace granary::tests
