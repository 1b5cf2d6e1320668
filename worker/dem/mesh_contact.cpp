#include "worker/dem/mesh_contact.h"

#include <algorithm>

namespace granary::dem {

using core::Vec3;

namespace {

Vec3 vector_of(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

void add(double (&sum)[3], const Vec3& v) {
  sum[0] += v.x;
  sum[1] += v.y;
  sum[2] += v.z;
}

// The velocity of a contact point, split along the normal and in the tangent plane.
struct Approach {
  Vec3 velocity;
  double normal;
  Vec3 sliding;
};

Approach approach_of(const MeshContact& contact, const GrainMotion& motion,
                     const GrainSurface& surface) {
  const Vec3& n = contact.touch.normal;
  const Vec3 centre_velocity = vector_of(motion.velocity);
  const Vec3 velocity = centre_velocity + cross(n, vector_of(surface.speed));
  const double normal = dot(centre_velocity, n);
  return {velocity, normal, velocity - n * normal};
}

// The half of the last step's dissipation that was still to come.
void book_last_half(const MeshContact& contact, const MeshLaw& law, const Approach& now,
                    ContactSums& sums) {
  if (!contact.touching) return;
  const double half_step = 0.5 * law.time_step;
  const double normal = now.normal * dot(contact.velocity, contact.touch.normal);
  sums.normal_damping += half_step * law.law.normal_damping * normal;
  sums.friction +=
      law.effects.tangential_history
          ? half_step * law.law.tangential_damping * (dot(now.velocity, contact.velocity) - normal)
          : -half_step * dot(contact.spring, now.sliding);
}

void book_first_half(const ContactForce& force, const MeshLaw& law, const Approach& now,
                     ContactSums& sums) {
  const double half_step = 0.5 * law.time_step;
  sums.normal_damping += half_step * law.law.normal_damping * now.normal * now.normal;
  if (!law.effects.tangential_history) {
    sums.friction -= half_step * dot(force.tangential, now.sliding);
    return;
  }
  const Vec3 step = now.sliding * law.time_step;
  sums.friction +=
      half_step * law.law.tangential_damping * dot(now.sliding, now.sliding) +
      law.law.tangential_stiffness * dot(force.slip, force.spring + (force.slip - step) * 0.5);
}

}  // namespace

History MeshContact::history() const {
  const auto narrow = [](double value) { return static_cast<float>(value); };
  return {{narrow(spring.x), narrow(spring.y), narrow(spring.z)},
          touching ? 1.0F : 0.0F,
          {narrow(velocity.x), narrow(velocity.y), narrow(velocity.z)},
          0};
}

void push(MeshContact& contact, const MeshLaw& law, const GrainMotion& motion,
          const GrainSurface& surface, GrainLoad& load, ContactSums& sums) {
  const Approach now = approach_of(contact, motion, surface);
  const Vec3 inward = -contact.touch.normal;  // contact_law.h: from the grain to its partner
  const double radius = surface.radius;
  ContactGeometry geometry;
  geometry.normal = inward;
  geometry.overlap = contact.touch.overlap;
  geometry.relative_velocity = geometry.damped_velocity = now.velocity;
  geometry.relative_spin = vector_of(surface.speed) * (1 / radius);
  geometry.radius_a = radius;
  const ContactForce force = evaluate_contact(geometry, law.law, law.effects, contact.spring,
                                              law.spin_response, law.time_step);
  book_last_half(contact, law, now, sums);
  book_first_half(force, law, now, sums);
  const Vec3 turning = law.effects.spin ? cross(inward, force.tangential) : Vec3{};
  const Vec3 mean_spin =
      geometry.relative_spin + turning * (0.5 * law.spin_response * law.time_step);
  sums.rolling -= law.time_step * dot(force.rolling_torque, mean_spin);
  sums.largest_overlap_ratio =
      std::max(sums.largest_overlap_ratio, static_cast<float>(contact.touch.overlap / radius));
  ++sums.contacts;
  add(load.force, inward * -force.normal + force.tangential);
  add(load.turning, turning + force.rolling_torque * (1 / radius));
  contact.spring = law.effects.tangential_history ? force.spring : force.tangential;
  contact.velocity = now.velocity;
  contact.touching = true;
}

void part(const MeshContact& contact, const MeshLaw& law, const GrainMotion& motion,
          const GrainSurface& surface, ContactSums& sums) {
  const Approach now = approach_of(contact, motion, surface);
  book_last_half(contact, law, now, sums);
  if (!law.effects.tangential_history) return;
  sums.friction += 0.5 * law.law.tangential_stiffness *
                   dot(contact.spring, contact.spring + now.sliding * law.time_step);
}

}  // namespace granary::dem
