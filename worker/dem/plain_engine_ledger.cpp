// Energy channels of the plain engine. Work is booked with the mean velocity over a kick, for which
// the leapfrog's change of kinetic energy is exact; stored energies are those of the half step,
// where the velocities live. What is left over is the second-order error of the step.
#include "worker/dem/plain_engine.h"

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

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

// A free grain comes (sign +1) or goes (-1): what is stored changes as the channel does.
void PlainEngine::book_transfer(EnergyChannel channel, const Body& body, double sign) {
  const double kinetic = kinetic_energy(body);
  const double potential = potential_energy(body);
  ledger_.kinetic_j += sign * kinetic;
  ledger_.potential_j += sign * potential;
  book(channel, -sign * (kinetic + potential));
}

// Velocity of a relative to b (or the wall) at their contact, and of their spins: from the mean
// over the last kick, or from the half step after it.
PlainEngine::Relative PlainEngine::relative(const Contact& contact, Moment moment) const {
  const Candidate& candidate = candidates_[contact.candidate];
  const ContactGeometry& geometry = contact.geometry;
  const auto velocity_of = [&](const Body& body) {
    return moment == Moment::mean_of_kick ? body.velocity_mean : body.velocity_half;
  };
  const auto spin_of = [&](const Body& body) {
    return moment == Moment::mean_of_kick ? body.spin_mean : body.spin_half;
  };
  const Body& a = bodies_[candidate.first];
  Relative relative{velocity_of(a), spin_of(a)};
  Vec3 surface_speed;
  if (candidate.is_wall()) {
    const double back = moment == Moment::mean_of_kick ? 1 : 0.5;
    relative.velocity -=
        map_.wall_velocity(a.position - a.velocity_half * (back * setup_.time_step));
    relative.spin -= map_.wall_spin();
    surface_speed = relative.spin * geometry.radius_a;
  } else {
    const Body& b = bodies_[candidate.second];
    relative.velocity -= velocity_of(b);
    relative.spin -= spin_of(b);
    surface_speed = spin_of(a) * geometry.radius_a + spin_of(b) * geometry.radius_b;
  }
  relative.velocity += cross(surface_speed, geometry.normal);
  return relative;
}

// Spring and attraction, which both have a potential [J].
double PlainEngine::normal_energy(const ContactCoefficients& law, double overlap) const {
  if (overlap <= 0) return 0;
  const double attraction = setup_.effects.cohesion ? law.cohesion * overlap : 0;
  return 0.5 * law.normal_stiffness * overlap * overlap - attraction;
}

// Half a step after the force evaluation: overlap and spring are carried on by half a step.
double PlainEngine::elastic_energy(const Contact& contact) const {
  const ContactCoefficients& law = law_of(candidates_[contact.candidate]);
  const Vec3& n = contact.geometry.normal;
  const double half_step = 0.5 * setup_.time_step;
  const Vec3 velocity = relative(contact, Moment::after_kick).velocity;
  const double approach = dot(velocity, n);
  const double overlap = contact.geometry.overlap + half_step * approach;
  Vec3 spring = contact.force.spring;
  if (setup_.effects.tangential_history) spring += (velocity - n * approach) * half_step;
  return normal_energy(law, overlap) + 0.5 * law.tangential_stiffness * dot(spring, spring);
}

// A grain that is put in with an overlap brings its elastic energy along.
void PlainEngine::book_first_overlap(const Contact& contact) {
  const Candidate& candidate = candidates_[contact.candidate];
  const bool fresh =
      bodies_[candidate.first].fresh || (!candidate.is_wall() && bodies_[candidate.second].fresh);
  if (!fresh) return;
  const ContactGeometry& geometry = contact.geometry;
  const double overlap =
      geometry.overlap - 0.5 * setup_.time_step * dot(geometry.relative_velocity, geometry.normal);
  if (overlap <= 0) return;
  book(EnergyChannel::inlet, -normal_energy(law_of(candidate), overlap));
}

void PlainEngine::book_step() {
  const double span = setup_.time_step;
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
  const ContactGeometry& geometry = contact.geometry;
  const ContactCoefficients& law = law_of(candidates_[contact.candidate]);
  const auto [velocity, spin] = relative(contact, Moment::mean_of_kick);
  const Vec3& slip = contact.force.slip;
  const Vec3 dashpot = contact.force.tangential + contact.force.spring * law.tangential_stiffness;
  // The spring loses what lies between its energy before and after it was shortened; the step that
  // shortened it moved by `sliding`, half of which was still booked against the long spring.
  const Vec3 n = geometry.normal;
  const Vec3 sliding =
      (geometry.relative_velocity - n * dot(geometry.relative_velocity, n)) * setup_.time_step;
  const double spring_loss = law.tangential_stiffness *
                             dot(slip, contact.force.spring + (slip - sliding) * 0.5) /
                             setup_.time_step;
  book(EnergyChannel::normal_damping, contact.force.damping_normal * dot(n, velocity) * span);
  book(EnergyChannel::friction, (spring_loss - dot(dashpot, velocity)) * span);
  book(EnergyChannel::rolling, -dot(contact.force.rolling_torque, spin) * span);
}

// What moving walls and carried grains put in.
void PlainEngine::book_drive(const Contact& contact, double span) {
  const Candidate& candidate = candidates_[contact.candidate];
  const Body& a = bodies_[candidate.first];
  const Vec3 force = contact.geometry.normal * -contact.force.normal + contact.force.tangential;
  if (candidate.is_wall()) {
    const Vec3 centre = a.position - a.velocity_half * setup_.time_step;
    const Vec3 arm = contact.geometry.normal * contact.geometry.radius_a;
    const double power = dot(force, map_.wall_velocity(centre + arm)) +
                         dot(contact.force.rolling_torque, map_.wall_spin());
    book(EnergyChannel::wall_work, -power * span);
    return;
  }
  const Body& b = bodies_[candidate.second];
  if (a.carried == b.carried) return;
  const Vec3& n = contact.geometry.normal;
  const Vec3& torque = contact.force.rolling_torque;
  const double power =
      a.carried ? -dot(force, a.velocity_mean + cross(a.spin_mean * contact.geometry.radius_a, n)) -
                      dot(torque, a.spin_mean)
                : dot(force, b.velocity_mean - cross(b.spin_mean * contact.geometry.radius_b, n)) +
                      dot(torque, b.spin_mean);
  book(EnergyChannel::inlet, -power * span);
}

void PlainEngine::update_stored() {
  ledger_.kinetic_j = ledger_.potential_j = ledger_.elastic_j = 0;
  for (const Body& body : bodies_) {
    if (body.carried) continue;
    ledger_.kinetic_j += kinetic_energy(body);
    ledger_.potential_j += potential_energy(body);
  }
  for (const Contact& contact : contacts_) ledger_.elastic_j += elastic_energy(contact);
}

}  // namespace granary::dem
