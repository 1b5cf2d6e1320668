// Energy channels of the plain engine. Work is booked with the mean velocity over a kick, for which
// the leapfrog's change of kinetic energy is exact; stored energies are those of the half step, where
// the velocities live. What is left over is the second-order error of the step.
#include "worker/dem/plain_engine.h"

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

void PlainEngine::book(EnergyChannel channel, double energy) {
  ledger_[channel] += energy;
  ledger_.throughput_j += std::abs(energy);
}

double PlainEngine::kinetic_energy(const Body& body) const {
  const GrainClass& grain_class = class_of(body);
  return 0.5 * grain_class.mass() * dot(body.velocity_half, body.velocity_half) +
         0.5 * grain_class.inertia() * dot(body.spin_half, body.spin_half);
}

// At the half step before `position`.
double PlainEngine::potential_energy(const Body& body) const {
  const Vec3 half_back = body.position - body.velocity_half * (0.5 * setup_.time_step);
  return -class_of(body).mass() * dot(setup_.motion.gravity, half_back);
}

double PlainEngine::mechanical_energy(const Body& body) const {
  return kinetic_energy(body) + potential_energy(body);
}

// Half a step after the force evaluation.
double PlainEngine::elastic_energy(const Contact& contact) const {
  const Candidate& candidate = candidates_[contact.candidate];
  const ContactCoefficients& law = law_of(candidate);
  Vec3 closing = bodies_[candidate.first].velocity_half;
  if (!candidate.is_wall()) {
    closing -= bodies_[candidate.second].velocity_half;
  } else {
    closing -= map_.wall_velocity(bodies_[candidate.first].position);
  }
  const double overlap =
      contact.geometry.overlap + 0.5 * setup_.time_step * dot(closing, contact.geometry.normal);
  const Vec3& spring = contact.force.spring;
  return (overlap > 0 ? 0.5 * law.normal_stiffness * overlap * overlap : 0) +
         0.5 * law.tangential_stiffness * dot(spring, spring);
}

// A grain that is put in with an overlap brings its elastic energy along.
void PlainEngine::book_first_overlap(const Contact& contact) {
  const Candidate& candidate = candidates_[contact.candidate];
  const bool fresh = bodies_[candidate.first].fresh ||
                     (!candidate.is_wall() && bodies_[candidate.second].fresh);
  if (!fresh) return;
  const ContactGeometry& geometry = contact.geometry;
  const double overlap = geometry.overlap - 0.5 * setup_.time_step *
                                                dot(geometry.relative_velocity, geometry.normal);
  if (overlap <= 0) return;
  book(EnergyChannel::inlet, -0.5 * law_of(candidate).normal_stiffness * overlap * overlap);
}

void PlainEngine::book_step() {
  const double span = static_cast<double>(step_ + 1 - booked_steps_) * setup_.time_step;
  booked_steps_ = step_ + 1;
  for (const Contact& contact : contacts_) {
    book_contact(contact, span);
    book_drive(contact, span);
  }
  double frame_work = 0;
  double gravity_work = 0;
  for (const Body& body : bodies_) {
    if (body.carried) continue;
    const double mass = class_of(body).mass();
    const Vec3 evaluated_at = body.position - body.velocity_half * setup_.time_step;
    frame_work += mass * dot(terms_.centrifugal(evaluated_at), body.velocity_mean);
    gravity_work += mass * dot(setup_.motion.gravity, body.velocity_mean);
  }
  book(EnergyChannel::frame_work, -frame_work * span);
  ledger_.throughput_j += std::abs(gravity_work) * span;
  update_stored();
}

// What a contact takes out of the grains, by the mean relative velocity of the kick.
void PlainEngine::book_contact(const Contact& contact, double span) {
  const Candidate& candidate = candidates_[contact.candidate];
  const Body& a = bodies_[candidate.first];
  const bool b_carried = !candidate.is_wall() && bodies_[candidate.second].carried;
  if (a.carried && (b_carried || candidate.is_wall())) return;
  const ContactGeometry& geometry = contact.geometry;
  const ContactCoefficients& law = law_of(candidate);
  Vec3 velocity = a.velocity_mean;
  Vec3 spin = a.spin_mean;
  Vec3 arms = a.spin_mean * geometry.radius_a;
  if (candidate.is_wall()) {
    velocity -= map_.wall_velocity(a.position - a.velocity_half * setup_.time_step);
    spin -= map_.wall_spin();
    arms = spin * geometry.radius_a;
  } else {
    const Body& b = bodies_[candidate.second];
    velocity -= b.velocity_mean;
    spin -= b.spin_mean;
    arms += b.spin_mean * geometry.radius_b;
  }
  velocity += cross(arms, geometry.normal);
  const Vec3 spring_force = contact.force.spring * law.tangential_stiffness;
  const Vec3 dashpot = contact.force.tangential + spring_force;
  const double damping = contact.force.normal - contact.force.elastic_normal;
  book(EnergyChannel::normal_damping, damping * dot(geometry.normal, velocity) * span);
  book(EnergyChannel::friction, -dot(dashpot, velocity) * span +
                                    dot(spring_force, contact.force.slip) * (span / setup_.time_step));
  book(EnergyChannel::rolling, -dot(contact.force.rolling_torque, spin) * span);
}

// What moving walls and carried grains put in.
void PlainEngine::book_drive(const Contact& contact, double span) {
  const Candidate& candidate = candidates_[contact.candidate];
  const Body& a = bodies_[candidate.first];
  const Vec3 force =
      contact.geometry.normal * -contact.force.normal + contact.force.tangential;
  if (candidate.is_wall()) {
    if (a.carried) return;
    const Vec3 centre = a.position - a.velocity_half * setup_.time_step;
    const Vec3 arm = contact.geometry.normal * contact.geometry.radius_a;
    const double power = dot(force, map_.wall_velocity(centre + arm)) +
                         dot(contact.force.rolling_torque, map_.wall_spin());
    book(EnergyChannel::wall_work, -power * span);
    return;
  }
  const Body& b = bodies_[candidate.second];
  if (a.carried == b.carried) return;
  const double power = a.carried ? -dot(force, a.velocity_mean) : dot(force, b.velocity_mean);
  book(EnergyChannel::inlet, -power * span);
}

void PlainEngine::update_stored() {
  ledger_.kinetic_j = ledger_.potential_j = ledger_.elastic_j = 0;
  for (const Body& body : bodies_) {
    if (body.carried) continue;
    ledger_.kinetic_j += kinetic_energy(body);
    ledger_.potential_j += potential_energy(body);
  }
  for (const Contact& contact : contacts_) {
    const Candidate& candidate = candidates_[contact.candidate];
    const bool a_carried = bodies_[candidate.first].carried;
    if (a_carried && (candidate.is_wall() || bodies_[candidate.second].carried)) continue;
    ledger_.elastic_j += elastic_energy(contact);
  }
}

}  // namespace granary::dem
