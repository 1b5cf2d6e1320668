#include "worker/dem/contact_law.h"

#include <gtest/gtest.h>

#include "tests/support/dem_cases.h"

namespace granary::dem {
namespace {

// Expected values: PHYSICS section A1, base case of the chute paper.
constexpr double kMass = 3.60498e-5;

TEST(ContactLaw, grain_pair_coefficients_follow_from_restitution) {
  const auto law = contact_coefficients(tests::base_grain_grain(), kMass / 2, true);
  EXPECT_NEAR(law.normal_damping, 2.60324e-3, 1e-8);
  EXPECT_NEAR(law.tangential_stiffness, 321.266, 1e-3);
  EXPECT_NEAR(law.tangential_damping, 2.70724e-2, 1e-7);
  EXPECT_NEAR(collision_time(tests::base_grain_grain(), kMass / 2), 4.21800e-4, 1e-9);
}

TEST(ContactLaw, wall_coefficients_follow_from_restitution) {
  const auto law = contact_coefficients(tests::base_grain_wall(), kMass, true);
  EXPECT_NEAR(law.normal_damping, 6.19918e-3, 1e-8);
  EXPECT_NEAR(law.tangential_stiffness, 321.211, 1e-3);
  EXPECT_NEAR(law.tangential_damping, 3.82829e-2, 1e-7);
  EXPECT_NEAR(collision_time(tests::base_grain_wall(), kMass), 5.96567e-4, 1e-9);
}

TEST(ContactLaw, perfectly_plastic_contact_is_critically_damped) {
  const ContactParameters plastic{1000, 0, 0.33, 0.1, 0, 0};
  EXPECT_DOUBLE_EQ(contact_coefficients(plastic, kMass, true).normal_damping,
                   2 * std::sqrt(kMass * 1000));
}

TEST(ContactLaw, without_spin_the_whole_mass_meets_the_tangential_spring) {
  const auto turning = contact_coefficients(tests::base_grain_grain(), kMass / 2, true);
  const auto fixed = contact_coefficients(tests::base_grain_grain(), kMass / 2, false);
  EXPECT_NEAR(fixed.tangential_stiffness / turning.tangential_stiffness, 3.5, 1e-12);
  EXPECT_NEAR(fixed.tangential_damping / turning.tangential_damping, 3.5, 1e-12);
}

ContactGeometry sliding_contact() {
  ContactGeometry contact;
  contact.normal = {0, 0, -1};
  contact.overlap = 1e-5;
  contact.relative_velocity = contact.damped_velocity = {0.3, 0.1, 0};
  contact.radius_a = 0.0015;
  return contact;
}

TEST(ContactLaw, coulomb_limit_shortens_the_spring_to_what_it_can_carry) {
  const auto law = contact_coefficients(tests::base_grain_wall(), kMass, true);
  const core::Vec3 long_spring{-1e-3, 0, 0};
  const auto force =
      evaluate_contact(sliding_contact(), law, ContactEffects{}, long_spring, 0, 1e-5);
  EXPECT_NEAR(norm(force.tangential), law.friction * force.normal, 1e-15);
  const core::Vec3 carried = force.spring * -law.tangential_stiffness -
                             core::Vec3{0.3, 0.1, 0} * law.tangential_damping;
  EXPECT_NEAR(norm(carried - force.tangential), 0, 1e-15);
}

TEST(ContactLaw, spring_stays_in_the_tangent_plane) {
  const auto law = contact_coefficients(tests::base_grain_wall(), kMass, true);
  const auto force =
      evaluate_contact(sliding_contact(), law, ContactEffects{}, {1e-8, 0, 5e-8}, 0, 1e-7);
  EXPECT_DOUBLE_EQ(force.spring.z, 0);
}

TEST(ContactLaw, rolling_torque_opposes_the_spin_and_never_reverses_it) {
  auto law = contact_coefficients(tests::base_grain_wall(), kMass, true);
  law.rolling_arm = 0.1 * 0.0015;
  law.reduced_inertia = 3.24448e-11;
  ContactGeometry contact = sliding_contact();
  contact.relative_velocity = contact.damped_velocity = {};
  contact.relative_spin = {0, 1e-3, 0};
  const double time_step = 1e-5;
  const auto slow = evaluate_contact(contact, law, ContactEffects{}, {}, 0, time_step);
  EXPECT_NEAR(contact.relative_spin.y + slow.rolling_torque.y / law.reduced_inertia * time_step, 0,
              1e-15);
  contact.relative_spin = {0, 100, 0};
  const auto fast = evaluate_contact(contact, law, ContactEffects{}, {}, 0, time_step);
  EXPECT_NEAR(fast.rolling_torque.y, -law.rolling_arm * fast.normal, 1e-18);
}

TEST(ContactLaw, effects_that_are_off_leave_no_trace) {
  auto law = contact_coefficients(tests::base_grain_wall(), kMass, true);
  law.rolling_arm = 1e-4;
  law.reduced_inertia = 3e-11;
  ContactGeometry contact = sliding_contact();
  contact.relative_spin = {0, 50, 0};
  const ContactEffects none{.tangential_history = false, .rolling_friction = false, .spin = true};
  const auto force = evaluate_contact(contact, law, none, {}, 0, 1e-5);
  EXPECT_EQ(force.rolling_torque, core::Vec3{});
  EXPECT_EQ(force.spring, core::Vec3{});
}

}  // namespace
}  // namespace granary::dem
