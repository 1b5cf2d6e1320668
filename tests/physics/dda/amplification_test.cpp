// Claim: the three integrators amplify a contact spring as theory says: spectral radius, period,
//   period-2 flip-flop of Newmark (1/2, 1) beyond Omega = w dt = 4; both solvers alike.
// Method: a disk pressed on a level wall, disturbed by 1e-3 of its static overlap so that the
//   contact never opens; three successive states give the 2 x 2 matrix of a step.
// Reference: PHYSICS A5. With (X, V dt): DDA A = [[2, 2], [-2 O^2, 2 - O^2]] / (2 + O^2); backward
//   Euler radius (1 + O^2)^-1/2; trapezoid radius 1, tan(phase / 2) = O / 2.
// Tolerance: 1e-6 (A5). Rounding: a disturbance of 3e-8 m on coordinates of 0.1 m carries 1e-9 of
// it. Seconds: < 0.1
#include <gtest/gtest.h>

#include <complex>

#include "tests/physics/dda/textbook.h"

namespace granary::dda {
namespace {

struct Amplification {
  double radius;
  double phase;  // rad per step; pi = changes sign every step
};

struct State {
  double x, v;
};

Amplification measure(SolverMethod method, Integrator integrator, double omega_dt) {
  constexpr double kRadius = 0.1, kStiffness = 1e7;
  System system;
  system.contact.stiffness = kStiffness;
  system.solver.method = method;
  system.solver.integrator = integrator;
  system.solver.small_step_kappa = 0;  // the integrator itself, one solve per step
  system.solver.tolerance = 1e-14;
  system.solver.max_sweeps = 2000;
  add_plane(system, 0, 1);
  add_disk(system, {0, kRadius}, kRadius, 1000);
  const double mass = 1 / system.disks.motion[0].inverse_mass;
  const double overlap = mass * system.gravity / kStiffness, rest = kRadius - overlap;
  system.time_step = omega_dt / std::sqrt(kStiffness / mass);
  system.disks.pose[0].y = rest + 1e-3 * overlap;
  reset_contacts(system);
  // At rest the contact force carries the weight; the disturbance is K times its size.
  system.contact_acceleration = {{0, system.gravity * (1 - 1e-3), 0}, {}};

  std::vector<State> states;
  for (int k = 0; k < 3; ++k) {
    states.push_back({(system.disks.pose[0].y - rest) / overlap,
                      system.disks.motion[0].vy * system.time_step / overlap});
    step(system);
  }
  // A [s0 s1] = [s1 s2].
  const auto& [s0, s1, s2] = std::tie(states[0], states[1], states[2]);
  const double area = s0.x * s1.v - s1.x * s0.v;
  const double a = (s1.x * s1.v - s2.x * s0.v) / area, b = (s2.x * s0.x - s1.x * s1.x) / area;
  const double c = (s1.v * s1.v - s2.v * s0.v) / area, d = (s2.v * s0.x - s1.v * s1.x) / area;
  const std::complex<double> root =
      std::sqrt(std::complex<double>((a + d) * (a + d) / 4 - (a * d - b * c)));
  const std::complex<double> first = (a + d) / 2 + root, second = (a + d) / 2 - root;
  const std::complex<double> larger = std::abs(first) > std::abs(second) ? first : second;
  return {std::abs(larger), std::abs(std::arg(larger))};
}

class AmplificationTest : public testing::TestWithParam<SolverMethod> {};

TEST_P(AmplificationTest, newmark_dda_damps_as_one_over_root_of_one_plus_half_omega_squared) {
  for (const auto& [omega, radius] :
       {std::pair{0.1, .99751}, {1.0, .8165}, {2.0, .57735}, {3.999, 0.3334}}) {
    const double measured = measure(GetParam(), Integrator::newmark_dda, omega).radius;
    EXPECT_NEAR(measured, 1 / std::sqrt(1 + omega * omega / 2), 1e-6) << omega;
    EXPECT_NEAR(measured, radius, 1e-4) << omega;
  }
}

TEST_P(AmplificationTest, newmark_dda_lengthens_the_period) {
  for (const auto& [omega, longer] : {std::pair{0.1, 0.001}, {1.0, 0.097}}) {
    const double phase = measure(GetParam(), Integrator::newmark_dda, omega).phase;
    const double cosine = (4 - omega * omega) / 2 / std::sqrt(2 * (2 + omega * omega));
    EXPECT_NEAR(phase, std::acos(cosine), 1e-6) << omega;
    EXPECT_NEAR(omega / phase - 1, longer, 1e-3) << omega;
  }
}

TEST_P(AmplificationTest, newmark_dda_flips_sign_every_step_beyond_omega_four) {
  for (const double omega : {5.0, 10.0, 100.0}) {
    const Amplification step = measure(GetParam(), Integrator::newmark_dda, omega);
    const double square = omega * omega, trace = (4 - square) / (2 + square);
    const double expected =
        (-trace + std::sqrt(trace * trace - 8 / (2 + square))) / 2;  // det = 2 / (2 + O^2)
    EXPECT_NEAR(step.radius, expected, 1e-6) << omega;
    EXPECT_NEAR(step.phase, std::numbers::pi, 1e-6) << omega;
  }
  EXPECT_NEAR(measure(GetParam(), Integrator::newmark_dda, 10).radius, 0.92, 0.001);
}

TEST_P(AmplificationTest, backward_euler_damps_as_one_over_root_of_one_plus_omega_squared) {
  for (const double omega : {0.1, 1.0, 10.0})
    EXPECT_NEAR(measure(GetParam(), Integrator::backward_euler, omega).radius,
                1 / std::sqrt(1 + omega * omega), 1e-6)
        << omega;
}

TEST_P(AmplificationTest, trapezoid_keeps_the_amplitude_at_any_step) {
  for (const double omega : {0.1, 1.0, 10.0}) {
    const Amplification step = measure(GetParam(), Integrator::newmark_trapezoid, omega);
    EXPECT_NEAR(step.radius, 1, 1e-6) << omega;
    EXPECT_NEAR(step.phase, 2 * std::atan(omega / 2), 1e-6) << omega;
  }
}

INSTANTIATE_TEST_SUITE_P(, AmplificationTest,
                         testing::Values(SolverMethod::impulse, SolverMethod::open_close),
                         [](const auto& info) {
                           return info.param == SolverMethod::impulse ? "impulse" : "open_close";
                         });

}  // namespace
}  // namespace granary::dda
