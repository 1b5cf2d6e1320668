// Claim: dashpots that see the velocity predicted to the full step, and springs that begin when the
//   grains touch, take away the first-order error of an impact.
// Method: sticking impact of one bead on the floor (mu = inf), mean slip after it over sixteen
// phases
//   of the onset within a step, against -e_t.
// Reference: PHYSICS section A1 (e_t = 0.33), D1 (the first-order error of half-step velocities).
// Tolerance: half-step velocities: a factor 4 in the step is 4 in the error, 10 % for the next
// order.
//   Predicted: (dt / t_c)^2 against dt / t_c at t_c / 60 leaves a sixtieth; a twentieth is asked.
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::tests {
namespace {

// Mean over sixteen phases of the onset within a step.
double restitution_error(dem::Damping damping, double time_step) {
  constexpr int kPhases = 16;
  double sum = 0;
  for (int phase = 0; phase < kPhases; ++phase) {
    dem::EngineSetup setup = base_setup(time_step);
    setup.walls = {floor_plane()};
    setup.grain_wall.friction = 1e6;
    setup.damping = damping;
    dem::PlainEngine engine(setup);
    const double radius = setup.classes[0].radius;
    const double above = (phase + 0.5) / kPhases * time_step;
    insert_one(engine, grain_at({0, 0, radius + above}, {1, 0, -1}));
    engine.advance(static_cast<std::uint64_t>(6.5e-4 / time_step));
    const Bead after = bead(engine);
    sum += -after.velocity.x + radius * after.spin.y;
  }
  return sum / kPhases - 0.33;
}

TEST(PredictedDamping, makes_impacts_second_order) {
  const double coarse = restitution_error(dem::Damping::semi_implicit, 1e-5);
  const double fine = restitution_error(dem::Damping::semi_implicit, 2.5e-6);
  EXPECT_NEAR(coarse / fine, 4, 0.4);
  EXPECT_LT(std::abs(restitution_error(dem::Damping::predicted_velocity, 1e-5)),
            0.05 * std::abs(coarse));
  EXPECT_LT(std::abs(restitution_error(dem::Damping::predicted_velocity, 2.5e-6)),
            0.05 * std::abs(fine));
}

}  // namespace
}  // namespace granary::tests
