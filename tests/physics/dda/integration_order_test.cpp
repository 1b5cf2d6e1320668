// Claim: Newmark (1/2, 1) and backward Euler are of first order, Newmark (1/4, 1/2) of second.
// Method: a contact spring with a period of 1 s that stays closed, one period at dt = .02, .01,
//   .005: the amplitude, and the position at the end of a quarter period.
// Reference: PHYSICS A5: amplitude errors -.179, -.094, -.048 of (1/2, 1), ratio 2.
// Tolerance: 1e-3 on the amplitude errors (printed to three digits); ratios within 10 % of 2, and
//   of 4, which leaves room for the next order at dt = .02 (Omega^2 = .016) several times over.
// Seconds: < 0.1
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

struct Oscillator {
  double x, v;  // of the amplitude; v over the angular frequency
};

Oscillator after(Integrator integrator, double dt, double duration) {
  constexpr double kRadius = 1, kShare = 0.1;
  System system;
  system.solver.integrator = integrator;
  system.solver.small_step_kappa = 0;  // the integrator itself, one solve per step
  system.solver.tolerance = 1e-13;
  system.solver.max_sweeps = 2000;
  system.time_step = dt;
  add_plane(system, 0, 1);
  add_disk(system, {0, kRadius}, kRadius, 1000);
  const double frequency = 2 * std::numbers::pi, mass = 1 / system.disks.motion[0].inverse_mass;
  system.contact.stiffness = mass * frequency * frequency;
  const double overlap = system.gravity / (frequency * frequency), rest = kRadius - overlap;
  system.disks.pose[0].y = rest + kShare * overlap;
  reset_contacts(system);
  system.contact_acceleration = {{0, system.gravity * (1 - kShare), 0}, {}};
  run(system, duration);
  return {(system.disks.pose[0].y - rest) / (kShare * overlap),
          system.disks.motion[0].vy / (kShare * overlap * frequency)};
}

double amplitude_error(Integrator integrator, double dt) {
  const Oscillator end = after(integrator, dt, 1);
  return std::hypot(end.x, end.v) - 1;
}

double phase_error(Integrator integrator, double dt) {
  return std::abs(after(integrator, dt, 0.5).v);  // passes the turning point at half a period
}

TEST(IntegrationOrder, of_newmark_dda_is_one) {
  const double coarse = amplitude_error(Integrator::newmark_dda, 0.02);
  const double middle = amplitude_error(Integrator::newmark_dda, 0.01);
  const double fine = amplitude_error(Integrator::newmark_dda, 0.005);
  EXPECT_NEAR(coarse, -.179, 1e-3);
  EXPECT_NEAR(middle, -.094, 1e-3);
  EXPECT_NEAR(fine, -.048, 1e-3);
  EXPECT_NEAR(middle / fine, 2, 0.1);
}

TEST(IntegrationOrder, of_backward_euler_is_one) {
  const double middle = amplitude_error(Integrator::backward_euler, 0.01);
  const double fine = amplitude_error(Integrator::backward_euler, 0.005);
  EXPECT_NEAR(middle / fine, 2, 0.2);
}

TEST(IntegrationOrder, of_the_trapezoid_is_two) {
  EXPECT_NEAR(amplitude_error(Integrator::newmark_trapezoid, 0.02), 0, 1e-9);
  const double coarse = phase_error(Integrator::newmark_trapezoid, 0.02);
  const double middle = phase_error(Integrator::newmark_trapezoid, 0.01);
  const double fine = phase_error(Integrator::newmark_trapezoid, 0.005);
  EXPECT_NEAR(coarse / middle, 4, 0.4);
  EXPECT_NEAR(middle / fine, 4, 0.4);
}

}  // namespace
}  // namespace granary::dda
