// How the plain engine finds what may touch: candidates from cells, planes and the mesh, kept while
// no grain has moved half a skin, and the geometry of each contact.
#include <algorithm>
#include <unordered_map>
#include <utility>

#include "worker/core/cell_grid.h"
#include "worker/core/random.h"
#include "worker/dem/plain_engine.h"

namespace granary::dem {

using core::Vec3;

namespace {

using PairKey = std::pair<std::int64_t, std::int64_t>;
struct PairKeyHash {
  std::size_t operator()(const PairKey& key) const {
    return core::mix64(static_cast<std::uint64_t>(key.first) * 0x9e3779b97f4a7c15ULL ^
                       static_cast<std::uint64_t>(key.second));
  }
};

}  // namespace

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
