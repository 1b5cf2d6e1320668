#include "worker/dem/plain_engine.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

namespace {

// Grains beyond the outlet are taken out every so many steps, whatever the chunks of the run; until
// then the floor still carries them.
constexpr std::uint64_t kOutletInterval = 24;
constexpr double kSkinInDiameters = 0.3;  // candidate pairs are closer than this

}  // namespace

PlainEngine::PlainEngine(const EngineSetup& setup)
    : setup_(setup),
      terms_(setup.motion, setup.time_step),
      coefficients_(pair_coefficients(setup)),
      mesh_(setup.triangles),
      map_(setup.motion, 0) {
  double smallest = setup.classes.front().radius;
  for (const GrainClass& grain_class : setup.classes) {
    smallest = std::min(smallest, grain_class.radius);
  }
  skin_ = kSkinInDiameters * 2 * smallest;
  spring_turn_ = core::rotation_matrix(map_.wall_spin() * setup.time_step);
  half_turn_ = core::rotation_matrix(map_.wall_spin() * (0.5 * setup.time_step));
}

// ------------------------------------------------------------------------------ grains in and out

std::int64_t PlainEngine::insert(std::span<const Grain> grains) {
  const std::int64_t first = next_id_;
  for (const Grain& grain : grains) {
    Body body;
    body.id = next_id_++;
    body.grain_class = grain.grain_class;
    body.position = map_.position_in(grain.position);
    body.velocity_half = map_.velocity_in(grain.velocity, grain.position);
    body.spin_half = setup_.effects.spin ? terms_.spin_half_step_back(map_.spin_in(grain.spin))
                                         : map_.wall_spin();
    body.spin_mean = body.spin_half;
    body.carried = grain.carried;
    body.carried_velocity = grain.velocity;
    if (!grain.carried) {
      body.velocity_half = terms_.half_step_back(body.velocity_half, body.position);
      book_transfer(EnergyChannel::inlet, body, 1);
    }
    bodies_.push_back(body);
  }
  list_is_void_ = true;
  return first;
}

void PlainEngine::release(std::int64_t first, std::int64_t end) {
  for (Body& body : bodies_) {
    if (!body.carried || body.id < first || body.id >= end) continue;
    body.carried = false;
    body.fresh = true;
    body.velocity_half = map_.velocity_in(body.carried_velocity, map_.position_out(body.position));
    body.velocity_half = terms_.half_step_back(body.velocity_half, body.position);
    book_transfer(EnergyChannel::inlet, body, 1);
  }
}

void PlainEngine::set_gravity(const Vec3& gravity) {
  for (const Body& body : bodies_) {
    if (!body.carried) book_transfer(EnergyChannel::outlet, body, -1);
  }
  setup_.motion.gravity = gravity;
  terms_ = BodyTerms(setup_.motion, setup_.time_step);
  for (const Body& body : bodies_) {
    if (!body.carried) book_transfer(EnergyChannel::inlet, body, 1);
  }
}

std::vector<Leaver> PlainEngine::take_leavers() {
  return std::exchange(leavers_, {});
}

// Within the step that crosses the outlet the grain moves in a straight line.
void PlainEngine::log_if_leaving(const Body& body) {
  const FrameMap next(setup_.motion, time() + setup_.time_step);
  const Vec3 now = next.position_out(body.position);
  const Vec3 before = map_.position_out(body.position - body.velocity_half * setup_.time_step);
  if (before.x > setup_.outlet_x || now.x <= setup_.outlet_x) return;
  const double share = (setup_.outlet_x - before.x) / (now.x - before.x);
  const GrainClass& grain_class = class_of(body);
  leavers_.push_back({time() + share * setup_.time_step, body.id, before + (now - before) * share,
                      (now - before) * (1 / setup_.time_step), 2 * grain_class.radius,
                      grain_class.mass()});
}

void PlainEngine::let_leavers_go() {
  const auto has_left = [&](const Body& body) {
    return map_.position_out(body.position).x > setup_.outlet_x;
  };
  for (const Contact& contact : contacts_) {
    const Candidate& candidate = candidates_[contact.candidate];
    const bool gone = has_left(bodies_[candidate.first]) ||
                      (!candidate.is_wall() && has_left(bodies_[candidate.second]));
    if (!gone) continue;
    const double elastic = elastic_energy(contact);
    ledger_.elastic_j -= elastic;
    book(EnergyChannel::outlet, elastic);
  }
  std::erase_if(bodies_, [&](const Body& body) {
    if (!has_left(body)) return false;
    book_transfer(EnergyChannel::outlet, body, -1);
    list_is_void_ = true;
    return true;
  });
}

EffectCounts PlainEngine::effect_counts() const {
  const bool rolls =
      setup_.effects.rolling_friction && setup_.effects.spin &&
      (setup_.grain_grain.rolling_friction > 0 || setup_.grain_wall.rolling_friction > 0);
  return {.tangential_history = setup_.effects.tangential_history ? contact_evaluations_ : 0,
          .rolling_friction = rolls ? contact_evaluations_ : 0,
          .spin = setup_.effects.spin ? particle_steps_ : 0,
          .cohesion = setup_.effects.cohesion ? contact_evaluations_ : 0,
          .rotating_frame = setup_.motion.rotates() ? particle_steps_ : 0};
}

GrainTable PlainEngine::grains() const {
  GrainTable table;
  for (const Body& body : bodies_) {
    const Vec3 velocity =
        body.carried ? body.velocity_half : terms_.half_step_on(body.velocity_half, body.position);
    table.id.push_back(body.id);
    table.position.push_back(map_.position_out(body.position));
    table.velocity.push_back(map_.velocity_out(velocity, body.position));
    table.spin.push_back(map_.spin_out(terms_.spin_half_step_on(body.spin_half)));
    table.radius.push_back(class_of(body).radius);
    table.mass.push_back(class_of(body).mass());
    table.grain_class.push_back(body.grain_class);
    table.carried.push_back(body.carried ? 1 : 0);
  }
  return table;
}

// --------------------------------------------------------------------------------------- the step

void PlainEngine::advance(std::uint64_t steps) {
  for (std::uint64_t k = 0; k < steps && !trouble_; ++k) step_once();
}

void PlainEngine::step_once() {
  refresh_candidates();
  place_walls();
  sum_forces();
  integrate();
  book_step();
  ++step_;
  map_ = FrameMap(setup_.motion, time());
  if (step_ % kOutletInterval == 0) {
    watch();
    let_leavers_go();
  }
}

void PlainEngine::place_walls() {
  walls_now_.clear();
  for (const Plane& wall : setup_.walls) {
    walls_now_.push_back({map_.position_in(wall.point), map_.direction_in(wall.normal)});
  }
}

void PlainEngine::sum_forces() {
  for (Body& body : bodies_) body.force = body.torque = {};
  contacts_.clear();
  touch_mesh();
  for (std::size_t k = 0; k < candidates_.size(); ++k) meet(k);
}

void PlainEngine::meet(std::size_t candidate_index) {
  Candidate& candidate = candidates_[candidate_index];
  if (is_prescribed(candidate)) return;
  Contact contact;
  contact.candidate = candidate_index;
  if (!find_contact(candidate, contact.geometry)) return part(candidate, contact.geometry);
  predict(candidate, contact.geometry);
  contact.force = evaluate_contact(contact.geometry, law_of(candidate), setup_.effects,
                                   spring_turn_ * candidate.spring, spin_response_of(candidate),
                                   setup_.time_step);
  if (!candidate.touching) book_first_overlap(contact);
  candidate.spring = contact.force.spring;
  candidate.velocity = contact.geometry.relative_velocity;
  candidate.touching = true;

  const Vec3& n = contact.geometry.normal;
  const Vec3 force = n * -contact.force.normal + contact.force.tangential;
  const Vec3 turning = cross(n, contact.force.tangential);
  Body& a = bodies_[candidate.first];
  a.force += force;
  a.torque += turning * contact.geometry.radius_a + contact.force.rolling_torque;
  if (!candidate.is_wall()) {
    Body& b = bodies_[candidate.second];
    b.force -= force;
    b.torque += turning * contact.geometry.radius_b - contact.force.rolling_torque;
  }
  const double smaller = candidate.is_wall()
                             ? contact.geometry.radius_a
                             : std::min(contact.geometry.radius_a, contact.geometry.radius_b);
  largest_overlap_ratio_ = std::max(largest_overlap_ratio_, contact.geometry.overlap / smaller);
  contacts_.push_back(contact);
  ++contact_evaluations_;
}

// Carried grains feel neither walls nor each other.
bool PlainEngine::is_prescribed(const Candidate& candidate) const {
  return bodies_[candidate.first].carried &&
         (candidate.is_wall() || bodies_[candidate.second].carried);
}

// The tangential spring of a contact that opens is lost: 1/2 k_t s.(s + v dt), which is its energy
// at the half step before, less the 1/8 k_t (v dt)^2 that it got for the share of its first step
// that lay before the contact.
void PlainEngine::part(Candidate& candidate, const ContactGeometry& geometry) {
  if (!candidate.touching) return;
  const Vec3& n = geometry.normal;
  const Vec3 sliding = geometry.relative_velocity - n * dot(geometry.relative_velocity, n);
  const Vec3& spring = candidate.spring;
  book(EnergyChannel::friction, 0.5 * law_of(candidate).tangential_stiffness *
                                    dot(spring, spring + sliding * setup_.time_step));
  candidate.spring = {};
  candidate.touching = false;
}

void PlainEngine::integrate() {
  const double dt = setup_.time_step;
  for (Body& body : bodies_) {
    if (body.carried) {
      carry(body);
      continue;
    }
    const GrainClass& grain_class = class_of(body);
    const Vec3 velocity = terms_.kick(body.velocity_half, body.force * (1 / grain_class.mass()) +
                                                              terms_.acceleration(body.position));
    body.velocity_mean = 0.5 * (body.velocity_half + velocity);
    body.velocity_half = velocity;
    if (setup_.effects.spin) {
      const Vec3 spin = terms_.kick_spin(body.spin_half, body.torque * (1 / grain_class.inertia()));
      body.spin_mean = 0.5 * (body.spin_half + spin);
      body.spin_half = spin;
    }
    body.position += velocity * dt;
    log_if_leaving(body);
    body.fresh = false;
    ++particle_steps_;
  }
}

void PlainEngine::carry(Body& body) {
  const Vec3 chute_position =
      map_.position_out(body.position) + body.carried_velocity * setup_.time_step;
  const FrameMap next(setup_.motion, time() + setup_.time_step);
  const Vec3 before = body.position;
  body.position = next.position_in(chute_position);
  body.velocity_half = (body.position - before) * (1 / setup_.time_step);
  body.velocity_mean = map_.velocity_in(body.carried_velocity, map_.position_out(before));
  body.spin_mean = body.spin_half;
  body.fresh = false;
}

void PlainEngine::watch() {
  const auto broken = std::find_if(bodies_.begin(), bodies_.end(), [](const Body& body) {
    return !std::isfinite(dot(body.position, body.velocity_half));
  });
  if (broken != bodies_.end()) {
    trouble_ = not_a_number(time(), {broken->id});
  } else if (largest_overlap_ratio_ > kLargestSoundOverlap) {
    trouble_ = overlap_too_deep(time(), largest_overlap_ratio_, deepest_ids());
  } else if (can_pass_through(bodies_.size(), !mesh_.empty())) {
    const auto fastest = std::max_element(
        bodies_.begin(), bodies_.end(),
        [this](const Body& l, const Body& r) { return path_ratio(l) < path_ratio(r); });
    if (fastest == bodies_.end() || path_ratio(*fastest) <= kLongestSoundPath) return;
    trouble_ = path_too_long(time(), path_ratio(*fastest), {fastest->id});
  }
}

double PlainEngine::path_ratio(const Body& body) const {
  const Vec3 velocity = body.velocity_half - map_.wall_velocity(body.position);
  return setup_.time_step * norm(velocity) / class_of(body).radius;
}

// Of the last step: the pair that overlaps most, or may have parted since.
std::vector<std::int64_t> PlainEngine::deepest_ids() const {
  const auto deepest = std::max_element(
      contacts_.begin(), contacts_.end(),
      [](const Contact& l, const Contact& r) { return l.geometry.overlap < r.geometry.overlap; });
  if (deepest == contacts_.end()) return {};
  const Candidate& candidate = candidates_[deepest->candidate];
  if (candidate.is_wall()) return {candidate.first_id};
  return {candidate.first_id, candidate.second_id};
}

// A quarter of a step's kick is left out for once: velocities were half a step before the
// positions, and count as a quarter of it from now on.
void PlainEngine::halve_time_step() {
  setup_.time_step *= 0.5;
  step_ *= 2;
  terms_ = BodyTerms(setup_.motion, setup_.time_step);
  spring_turn_ = core::rotation_matrix(map_.wall_spin() * setup_.time_step);
  half_turn_ = core::rotation_matrix(map_.wall_spin() * (0.5 * setup_.time_step));
  list_is_void_ = true;
  largest_overlap_ratio_ = 0;
  trouble_.reset();
}

}  // namespace granary::dem
