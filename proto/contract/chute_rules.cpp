#include "proto/contract/chute_rules.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "proto/contract/rule_text.h"
#include "proto/contract/stl.h"

namespace granary {
namespace {

constexpr double kPi = 3.14159265358979323846;
// An inlet that rams grains into resting ones deeper than this share of a radius is no soft sphere.
constexpr double kDeepestImpact = 0.5;
constexpr double kLatticeSolidFraction = 0.68017;  // touching bcc, pi sqrt(3) / 8
constexpr int kMaxClasses = 8;                     // the engine's tables of pairs
constexpr int kMaxWalls = 64;
// Of a chute at most: floor, sides, ends, and what shuts it for filling.
constexpr int kOwnWalls = 7;
constexpr double kFillFraction = 0.6;  // solid fraction of a settled hopper, loose random packing

std::optional<Error> check_available(const v1::Chute& chute) {
  if (chute.meshes_size() > 0)
    return refuse("chute.meshes[0].stl_file",
                  "names a file: only the program that reads the scene from a file opens it, a job "
                  "carries chute.triangles");
  if (chute.particles_size() > kMaxClasses)
    return refuse("chute.particles",
                  "has more than " + std::to_string(kMaxClasses) + " size classes");
  return {};
}

double largest_diameter(const v1::Chute& chute) {
  double largest = 0;
  for (const auto& particle : chute.particles()) largest = std::max(largest, particle.diameter_m());
  return largest;
}

// ------------------------------------------------------------------------------------------ walls

using Triple = std::array<double, 3>;
struct Wall {
  Triple point, normal;  // unit, into the flow
};

double dot(const Triple& a, const Triple& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

std::vector<Wall> walls_of(const v1::Chute& chute) {
  std::vector<Wall> walls;
  if (!chute.no_walls())
    walls = {{{0, 0, 0}, {0, 0, 1}}, {{0, 0, 0}, {0, 1, 0}}, {{0, chute.width_m(), 0}, {0, -1, 0}}};
  if (chute.closed_end()) {
    walls.push_back({{chute.length_m(), 0, 0}, {-1, 0, 0}});
    if (chute.inlet().feed() == v1::Inlet::NONE) walls.push_back({{0, 0, 0}, {1, 0, 0}});
  }
  if (chute.inlet().feed() == v1::Inlet::HOPPER)
    walls.push_back({{-chute.inlet().hopper_length_m(), 0, 0}, {1, 0, 0}});
  for (const v1::WallPlane& plane : chute.planes()) {
    Wall wall{{plane.point_m(0), plane.point_m(1), plane.point_m(2)},
              {plane.normal(0), plane.normal(1), plane.normal(2)}};
    const double length = std::sqrt(dot(wall.normal, wall.normal));
    for (double& component : wall.normal) component /= length;
    walls.push_back(wall);
  }
  return walls;
}

std::optional<Error> check_planes(const v1::Chute& chute) {
  for (int k = 0; k < chute.planes_size(); ++k) {
    const auto& normal = chute.planes(k).normal();
    if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0)
      return refuse("chute.planes[" + std::to_string(k) + "].normal", "must not be zero");
  }
  if (chute.planes_size() > kMaxWalls - kOwnWalls)
    return refuse("chute.planes", "are more than " + std::to_string(kMaxWalls - kOwnWalls));
  return {};
}

std::optional<Error> check_triangles(const v1::Chute& chute) {
  if (chute.triangles_size() > static_cast<int>(kMaxTriangles))
    return refuse("chute.triangles", "are " + std::to_string(chute.triangles_size()) +
                                         ", must be <= " + std::to_string(kMaxTriangles));
  for (int k = 0; k < chute.triangles_size(); ++k) {
    TriangleCorners corners;
    std::copy_n(chute.triangles(k).vertices_m().begin(), corners.size(), corners.begin());
    if (!has_area(corners))
      return refuse("chute.triangles[" + std::to_string(k) + "].vertices_m",
                    "has no area: its corners lie on one line");
  }
  return {};
}

// Two planes that face each other must leave room for the largest grain.
std::optional<Error> check_room(const v1::Chute& chute) {
  const std::vector<Wall> walls = walls_of(chute);
  const double diameter = largest_diameter(chute);
  for (std::size_t a = 0; a < walls.size(); ++a) {
    for (std::size_t b = a + 1; b < walls.size(); ++b) {
      if (dot(walls[a].normal, walls[b].normal) > -1 + 1e-9) continue;
      const double room =
          dot(walls[b].point, walls[a].normal) - dot(walls[a].point, walls[a].normal);
      if (room >= diameter) continue;
      return refuse(chute.planes_size() > 0 ? "chute.planes" : "chute.width_m",
                    "walls overlap or stand " + rounded(room) +
                        " m apart, must leave one grain diameter = " + rounded(diameter) + " m");
    }
  }
  return {};
}

// ------------------------------------------------------------------------------------------ inlet

std::optional<Error> check_inlet_speed(const v1::Chute& chute) {
  const v1::Inlet& inlet = chute.inlet();
  const bool feeds = inlet.feed() == v1::Inlet::LATTICE && inlet.mass_flow_kg_per_s() > 0;
  if (!feeds) return {};
  double mass = 0, radius = 0, bulk_density = 0, shares = 0;
  for (const auto& particle : chute.particles()) {
    const double m = particle.density_kg_per_m3() * kPi / 6 * std::pow(particle.diameter_m(), 3);
    if (m > mass) mass = m, radius = particle.diameter_m() / 2;
    bulk_density += particle.mass_fraction() * particle.density_kg_per_m3();
    shares += particle.mass_fraction();
  }
  const double section = chute.width_m() * inlet.sluice_height_m();
  const double speed =
      inlet.mass_flow_kg_per_s() / (kLatticeSolidFraction * bulk_density / shares * section);
  const double fastest = kDeepestImpact * radius *
                         std::sqrt(chute.contact_pp().normal_stiffness_n_per_m() / (0.5 * mass));
  if (speed <= fastest) return {};
  return refuse("chute.inlet.mass_flow_kg_per_s",
                "= " + rounded(inlet.mass_flow_kg_per_s()) + " needs an inlet speed of " +
                    rounded(speed) + " m/s, the lattice allows <= " + rounded(fastest) +
                    " m/s (impacts of half a radius at this stiffness)");
}

// The slot lets a grain through; what would be ignored is refused.
std::optional<Error> check_hopper(const v1::Chute& chute) {
  const v1::Inlet& inlet = chute.inlet();
  if (inlet.feed() != v1::Inlet::HOPPER) return {};
  const double diameter = largest_diameter(chute);
  const struct {
    const char* field;
    double value, least, most;
    const char* why;
  } limits[] = {
      {"hopper_opening_m", inlet.hopper_opening_m(), diameter, inlet.hopper_height_m(),
       "one diameter to hopper_height_m"},
      {"hopper_length_m", inlet.hopper_length_m(), 2 * diameter, 10, "two diameters to 10 m"},
      {"hopper_opening_width_m",
       inlet.has_hopper_opening_width_m() ? inlet.hopper_opening_width_m() : chute.width_m(),
       diameter, chute.width_m(), "one diameter to width_m"},
  };
  for (const auto& limit : limits) {
    if (limit.value >= limit.least && limit.value <= limit.most) continue;
    return refuse(std::string("chute.inlet.") + limit.field,
                  "= " + number(limit.value) +
                      " is out of range, must be >= " + number(limit.least) +
                      " and <= " + number(limit.most) + " (" + limit.why + ")");
  }
  if (inlet.has_mass_flow_kg_per_s() || inlet.has_sluice_height_m())
    return refuse(inlet.has_mass_flow_kg_per_s() ? "chute.inlet.mass_flow_kg_per_s"
                                                 : "chute.inlet.sluice_height_m",
                  "stands beside feed HOPPER, whose flow is what comes out of its slot");
  if (chute.initial_count() > 0)
    return refuse("chute.initial_count", "stands beside feed HOPPER, which fills itself");
  if (chute.no_walls())
    return refuse("chute.no_walls", "stands beside feed HOPPER, which stands between the walls");
  return {};
}

std::optional<Error> check_opening(const v1::Chute& chute) {
  if (chute.inlet().feed() == v1::Inlet::NONE || chute.width_m() >= largest_diameter(chute))
    return {};
  return refuse("chute.width_m", "= " + rounded(chute.width_m()) + " is out of range, must be >= " +
                                     rounded(largest_diameter(chute)) + " (one diameter)");
}

}  // namespace

std::uint64_t hopper_grain_count(const v1::Chute& chute) {
  const v1::Inlet& inlet = chute.inlet();
  if (inlet.feed() != v1::Inlet::HOPPER) return 0;
  double grains = 0, volume = 0;  // per kilogram
  for (const auto& particle : chute.particles()) {
    const double specific = particle.mass_fraction() / particle.density_kg_per_m3();
    volume += specific;
    grains += specific / (kPi / 6 * std::pow(particle.diameter_m(), 3));
  }
  const double bin = inlet.hopper_length_m() * chute.width_m() * inlet.hopper_height_m();
  return static_cast<std::uint64_t>(kFillFraction * bin * grains / volume);
}

std::optional<Error> check_resolved_chute(const v1::Chute& chute) {
  for (const auto check : {check_available, check_planes, check_triangles, check_opening,
                           check_hopper, check_room, check_inlet_speed}) {
    if (auto error = check(chute)) return error;
  }
  return {};
}

}  // namespace granary
