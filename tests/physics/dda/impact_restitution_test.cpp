// Claim: without contact damping the rebound of Newmark (1/2, 1) follows the step, not the
// material:
//   exp(-pi Omega / 4) for small Omega = dt sqrt(K / m), mean 1/2 at Omega = 1 and 1/3 at 2, and in
//   the stiff limit |1 - 2 f| with f the phase of the impact; so no setting of it is free of
//   restitution by itself. Backward Euler only loses energy.
// Method: a disk without gravity hits a wall, gap 10 v dt + f v dt, for 200 phases f.
// Reference: PHYSICS A5 (.925 at .1, .855 at .2, .68 at .5; stiff: mean 1/2, <e^2> = 1/3).
// Tolerance: 1 % of the value (A5); means over 200 equidistant phases of a function with bounded
//   slope 2 err by 2 / 400; the stiff limit itself by 1 / Omega^2 = 1e-6.
// Seconds: 0.2
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

constexpr int kPhases = 200;

double phase_of(int k) {
  return (k + 0.5) / kPhases;
}

double rebound(Integrator integrator, double omega_dt, double phase) {
  constexpr double kRadius = 0.002, kSpeed = 1;
  System system;
  system.gravity = 0;
  system.solver.integrator = integrator;
  system.solver.small_step_kappa = 0;  // the integrator itself, one solve per step
  system.solver.tolerance = 1e-12;
  system.solver.max_sweeps = 2000;
  add_plane(system, 0, 1);
  add_disk(system, {0, 0}, kRadius, 1000);
  const double mass = 1 / system.disks.motion[0].inverse_mass;
  system.time_step = 1e-6;
  system.contact.stiffness = mass * std::pow(omega_dt / system.time_step, 2);
  system.disks.pose[0].y = kRadius + (10 + phase) * kSpeed * system.time_step;
  system.disks.motion[0].vy = -kSpeed;
  reset_contacts(system);
  const int steps = 20 + static_cast<int>(2 * std::numbers::pi / omega_dt);
  for (int k = 0; k < steps; ++k) step(system);
  EXPECT_EQ(system.report.contacts == 0 || system.wall_contacts.impulse_n[0] == 0, true);
  return system.disks.motion[0].vy / kSpeed;
}

struct Moments {
  double mean = 0, square = 0;
};

Moments rebounds(Integrator integrator, double omega_dt) {
  Moments moments;
  for (int k = 0; k < kPhases; ++k) {
    const double e = rebound(integrator, omega_dt, phase_of(k));
    moments.mean += e / kPhases;
    moments.square += e * e / kPhases;
  }
  return moments;
}

TEST(ImpactRestitution, of_newmark_dda_falls_exponentially_with_small_omega) {
  for (const auto& [omega, expected] : {std::pair{0.1, 0.925}, {0.2, 0.855}, {0.5, 0.68}})
    EXPECT_NEAR(rebounds(Integrator::newmark_dda, omega).mean, expected, 0.01 * expected) << omega;
}

TEST(ImpactRestitution, of_newmark_dda_is_a_half_at_omega_one_and_a_third_at_two) {
  EXPECT_NEAR(rebounds(Integrator::newmark_dda, 1).mean, 0.50, 0.01);
  EXPECT_NEAR(rebounds(Integrator::newmark_dda, 2).mean, 1.0 / 3, 0.01);
}

TEST(ImpactRestitution, of_newmark_dda_in_the_stiff_limit_is_the_phase_of_the_impact) {
  for (const double phase : {0.1, 0.3, 0.5, 0.7, 0.9})
    EXPECT_NEAR(rebound(Integrator::newmark_dda, 1e3, phase), std::abs(1 - 2 * phase), 1e-2)
        << phase;
  const Moments moments = rebounds(Integrator::newmark_dda, 1e3);
  EXPECT_NEAR(moments.mean, 0.5, 0.01);
  EXPECT_NEAR(moments.square, 1.0 / 3, 0.01);
}

TEST(ImpactRestitution, of_backward_euler_never_gains_energy) {
  double last = 1;
  for (const double omega : {0.1, 1.05, 10.4}) {  // kappa 0.011, 1.1, 109 of PHYSICS F
    const double mean = rebounds(Integrator::backward_euler, omega).mean;
    EXPECT_LT(mean, last);
    last = mean;
    for (int k = 0; k < kPhases; k += 10)
      EXPECT_LE(rebound(Integrator::backward_euler, omega, phase_of(k)), 1 + 1e-9);
  }
  EXPECT_LT(last, 0.01);
}

}  // namespace
}  // namespace granary::dda
