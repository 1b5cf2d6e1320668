#include "worker/dem/plain_engine.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>

#include "worker/core/cell_grid.h"
#include "worker/core/random.h"

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

namespace {

// Grains beyond the outlet are taken out every so many steps, whatever the chunks of the run; until
// then the floor still carries them.
constexpr std::uint64_t kOutletInterval = 24;
constexpr double kSkinInDiameters = 0.3;  // candidate pairs are closer than this

using PairKey = std::pair<std::int64_t, std::int64_t>;
struct PairKeyHash {
  std::size_t operator()(const PairKey& key) const {
    return core::mix64(static_cast<std::uint64_t>(key.first) * 0x9e3779b97f4a7c15ULL ^
                       static_cast<std::uint64_t>(key.second));
  }
};

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
  } else {
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

// ------------------------------------------------------------------------------- finding contacts

const ContactCoefficients& PlainEngine::law_of(const Candidate& candidate) const {
  const std::size_t a = bodies_[candidate.first].grain_class;
  if (candidate.is_wall()) return coefficients_.grain_wall[a];
  return coefficients_
      .grain_grain[a * setup_.classes.size() + bodies_[candidate.second].grain_class];
}

double PlainEngine::spin_response_of(const Candidate& candidate) const {
  if (!setup_.effects.spin) return 0;
  const GrainClass& a = class_of(bodies_[candidate.first]);
  const double response = a.radius / a.inertia();
  if (candidate.is_wall()) return response;
  const GrainClass& b = class_of(bodies_[candidate.second]);
  return response - b.radius / b.inertia();
}

SurfaceTouch PlainEngine::wall_touch(const Candidate& candidate) const {
  if (candidate.wall() >= walls_now_.size()) {
    return {candidate.touch.normal, candidate.is_met ? candidate.touch.overlap : 0};
  }
  const Body& a = bodies_[candidate.first];
  const Plane& wall = walls_now_[candidate.wall()];
  return {wall.normal, class_of(a).radius - dot(a.position - wall.point, wall.normal)};
}

// Finds what every grain touches of the mesh, and which of its slots each touch goes on in.
void PlainEngine::touch_mesh() {
  for (const Surroundings& near : near_mesh_) {
    const std::span<Candidate> slots = std::span(candidates_).subspan(near.candidate, kMostTouches);
    const Body& body = bodies_[slots[0].first];
    TouchList touches =
        mesh_.touches(map_.position_out(body.position), class_of(body).radius,
                      std::span(near_triangles_).subspan(near.begin, near.end - near.begin), feet_);
    for (std::size_t k = 0; k < touches.count; ++k) {
      touches.touch[k].normal = map_.direction_in(touches.touch[k].normal);
    }
    assign_touches(touches.all(), slots);
  }
}

// Velocities are those of the half step before, as always in the semi-implicit scheme. Walls that
// turn are seen as from the corotating frame: half a step back, and carried on with them by half a
// turn.
bool PlainEngine::find_contact(const Candidate& candidate, ContactGeometry& geometry) const {
  const Body& a = bodies_[candidate.first];
  geometry.radius_a = class_of(a).radius;
  if (candidate.is_wall()) {
    const SurfaceTouch touch = wall_touch(candidate);
    geometry.overlap = touch.overlap;
    if (geometry.overlap <= 0 && !candidate.touching) return false;
    geometry.normal = -touch.normal;
    const Vec3 half_back = a.position - a.velocity_half * (0.5 * setup_.time_step);
    geometry.relative_spin = half_turn_ * (a.spin_half - map_.wall_spin());
    geometry.relative_velocity = half_turn_ * (a.velocity_half - map_.wall_velocity(half_back)) +
                                 cross(geometry.relative_spin * geometry.radius_a, geometry.normal);
    return geometry.overlap > 0;
  }
  const Body& b = bodies_[candidate.second];
  geometry.radius_b = class_of(b).radius;
  const Vec3 apart = b.position - a.position;
  const double distance = norm(apart);
  geometry.overlap = geometry.radius_a + geometry.radius_b - distance;
  if (geometry.overlap <= 0 && !candidate.touching) return false;
  geometry.normal = apart * (1 / distance);
  geometry.relative_spin = half_turn_ * (a.spin_half - b.spin_half);
  const Vec3 surface_speeds = a.spin_half * geometry.radius_a + b.spin_half * geometry.radius_b;
  geometry.relative_velocity = half_turn_ * (a.velocity_half - b.velocity_half) +
                               cross(half_turn_ * surface_speeds, geometry.normal);
  return geometry.overlap > 0;
}

// Dashpots see the velocity of the half step before; or, predicted, that velocity carried on to the
// full step by what it changed by since the last one. Grains that touch for the first time came on
// unforced, and slide on each other only since they touch.
void PlainEngine::predict(const Candidate& candidate, ContactGeometry& geometry) const {
  const Vec3& now = geometry.relative_velocity;
  geometry.damped_velocity = now;
  if (setup_.damping == Damping::semi_implicit) return;
  if (candidate.touching) {
    geometry.damped_velocity = now + (now - spring_turn_ * candidate.velocity) * 0.5;
  } else {
    const double path = dot(now, geometry.normal) * setup_.time_step;
    if (path > geometry.overlap) geometry.touched_share = geometry.overlap / path;
  }
}

bool PlainEngine::candidates_are_stale() const {
  if (list_is_void_) return true;
  const double allowed = 0.25 * skin_ * skin_;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Vec3 moved = map_.position_out(bodies_[k].position) - listed_at_[k];
    if (dot(moved, moved) > allowed) return true;
  }
  return false;
}

void PlainEngine::refresh_candidates() {
  if (!candidates_are_stale()) return;
  std::unordered_map<PairKey, const Candidate*, PairKeyHash> touching;
  for (const Candidate& old : candidates_) {
    if (old.touching) touching[{old.first_id, old.second_id}] = &old;
  }
  std::vector<Candidate> fresh = collect_candidates();
  for (Candidate& candidate : fresh) {
    const auto old = touching.find({candidate.first_id, candidate.second_id});
    if (old == touching.end()) continue;
    candidate.spring = old->second->spring;
    candidate.velocity = old->second->velocity;
    candidate.touch = old->second->touch;
    candidate.touching = true;
  }
  candidates_ = std::move(fresh);
  listed_at_.clear();
  for (const Body& body : bodies_) listed_at_.push_back(map_.position_out(body.position));
  list_is_void_ = false;
}

std::vector<PlainEngine::Candidate> PlainEngine::collect_candidates() {
  std::vector<Vec3> points;
  double largest = 0;
  for (const Body& body : bodies_) {
    points.push_back(map_.position_out(body.position));
    largest = std::max(largest, class_of(body).radius);
  }
  core::CellGrid grid;
  grid.build(points, 2 * largest + skin_);
  near_mesh_.clear();
  near_triangles_.clear();
  std::vector<Candidate> list;
  for (std::size_t a = 0; a < points.size(); ++a) {
    const std::size_t first_of_a = list.size();
    add_neighbours_of(a, points, grid, list);
    std::sort(list.begin() + static_cast<std::ptrdiff_t>(first_of_a), list.end(),
              [](const Candidate& l, const Candidate& r) { return l.second < r.second; });
    add_walls_of(a, points[a], list);
    add_surface_of(a, points[a], list);
  }
  return list;
}

void PlainEngine::add_neighbours_of(std::size_t a, std::span<const Vec3> points,
                                    const core::CellGrid& grid,
                                    std::vector<Candidate>& list) const {
  const auto home = grid.coordinates(points[a]);
  const auto counts = grid.counts();
  const auto low = [](std::int32_t c) { return std::max(c - 1, 0); };
  const auto high = [](std::int32_t c, std::int32_t count) { return std::min(c + 1, count - 1); };
  for (std::int32_t x = low(home[0]); x <= high(home[0], counts[0]); ++x) {
    for (std::int32_t y = low(home[1]); y <= high(home[1], counts[1]); ++y) {
      for (std::int32_t z = low(home[2]); z <= high(home[2], counts[2]); ++z) {
        for (const std::uint32_t b : grid.points_in(grid.index({x, y, z}))) {
          if (b <= a) continue;
          const double reach = class_of(bodies_[a]).radius + class_of(bodies_[b]).radius + skin_;
          const Vec3 apart = points[b] - points[a];
          if (dot(apart, apart) >= reach * reach) continue;
          list.push_back({.first = static_cast<std::int32_t>(a),
                          .second = static_cast<std::int32_t>(b),
                          .first_id = bodies_[a].id,
                          .second_id = bodies_[b].id});
        }
      }
    }
  }
}

void PlainEngine::add_walls_of(std::size_t a, const Vec3& point,
                               std::vector<Candidate>& list) const {
  for (std::size_t w = 0; w < setup_.walls.size(); ++w) {
    const double gap =
        dot(point - setup_.walls[w].point, setup_.walls[w].normal) - class_of(bodies_[a]).radius;
    if (gap >= skin_) continue;
    const auto wall = static_cast<std::int32_t>(-1 - static_cast<std::int32_t>(w));
    list.push_back({.first = static_cast<std::int32_t>(a),
                    .second = wall,
                    .first_id = bodies_[a].id,
                    .second_id = wall});
  }
}

void PlainEngine::add_surface_of(std::size_t a, const Vec3& point, std::vector<Candidate>& list) {
  if (mesh_.empty()) return;
  const auto begin = static_cast<std::uint32_t>(near_triangles_.size());
  mesh_.add_near(point, class_of(bodies_[a]).radius + skin_, near_triangles_);
  const auto end = static_cast<std::uint32_t>(near_triangles_.size());
  if (begin == end) return;
  near_mesh_.push_back({list.size(), begin, end});
  for (std::size_t slot = 0; slot < kMostTouches; ++slot) {
    const auto wall = -1 - static_cast<std::int32_t>(setup_.walls.size() + slot);
    list.push_back({.first = static_cast<std::int32_t>(a),
                    .second = wall,
                    .first_id = bodies_[a].id,
                    .second_id = wall});
  }
}

}  // namespace granary::dem
