#include "worker/dem/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace granary::dem {

using core::Vec3;

namespace {

constexpr std::uint32_t kTrianglesPerLeaf = 4;
// A foot this near another triangle, in radii, lies on it: corners of a file are rounded.
constexpr double kOnTriangle = 1e-4;

double component(const Vec3& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

double square_of(const Vec3& v) {
  return dot(v, v);
}

// Barycentric regions of the plane around a triangle, after Voronoi's cells of its corners, edges
// and face. `on_face` is set where the point projects onto the inside.
Vec3 nearest_point(const Vec3 (&corner)[3], const Vec3& point, bool& on_face) {
  const Vec3 &a = corner[0], &b = corner[1], &c = corner[2];
  on_face = false;
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 from_a = point - a;
  const double a1 = dot(ab, from_a), a2 = dot(ac, from_a);
  if (a1 <= 0 && a2 <= 0) return a;
  const Vec3 from_b = point - b;
  const double b1 = dot(ab, from_b), b2 = dot(ac, from_b);
  if (b1 >= 0 && b2 <= b1) return b;
  const double on_ab = a1 * b2 - b1 * a2;
  if (on_ab <= 0 && a1 >= 0 && b1 <= 0) return a + ab * (a1 / (a1 - b1));
  const Vec3 from_c = point - c;
  const double c1 = dot(ab, from_c), c2 = dot(ac, from_c);
  if (c2 >= 0 && c1 <= c2) return c;
  const double on_ac = c1 * a2 - a1 * c2;
  if (on_ac <= 0 && a2 >= 0 && c2 <= 0) return a + ac * (a2 / (a2 - c2));
  const double on_bc = b1 * c2 - c1 * b2;
  const double along = b2 - b1, back = c1 - c2;
  if (on_bc <= 0 && along >= 0 && back >= 0) return b + (c - b) * (along / (along + back));
  on_face = true;
  const double scale = 1 / (on_bc + on_ac + on_ab);
  return a + ab * (on_ac * scale) + ac * (on_ab * scale);
}

}  // namespace

SurfaceMesh::SurfaceMesh(std::span<const Triangle> triangles) {
  for (const Triangle& t : triangles) {
    const Vec3 area = cross(t.b - t.a, t.c - t.a);
    const double size = norm(area);
    facets_.push_back({{t.a, t.b, t.c}, {area.x / size, area.y / size, area.z / size}});
  }
  order_.resize(facets_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  if (!facets_.empty()) build(0, static_cast<std::uint32_t>(facets_.size()));
}

// ------------------------------------------------------------------------------- the tree of boxes

SurfaceMesh::Box SurfaceMesh::box_of(std::uint32_t begin, std::uint32_t end) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (std::uint32_t k = begin; k < end; ++k) {
    for (const Vec3& p : facets_[order_[k]].corner) {
      box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
      box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
    }
  }
  return box;
}

std::uint32_t SurfaceMesh::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({box_of(begin, end), begin, end, 0});
  if (end - begin <= kTrianglesPerLeaf) return index;
  const Vec3 size = nodes_[index].box.high - nodes_[index].box.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto middle_of = [&](std::uint32_t t) {
    const auto& corner = facets_[t].corner;
    return component(corner[0] + corner[1] + corner[2], axis);
  };
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                   [&](std::uint32_t l, std::uint32_t r) {
                     return std::pair(middle_of(l), l) < std::pair(middle_of(r), r);
                   });
  build(begin, half);
  const std::uint32_t right = build(half, end);
  nodes_[index].right = right;
  return index;
}

void SurfaceMesh::search(std::uint32_t node, const Vec3& point, double reach,
                         std::vector<std::uint32_t>& found) const {
  const auto& [box, begin, end, right] = nodes_[node];
  const Vec3 inside{std::clamp(point.x, box.low.x, box.high.x),
                    std::clamp(point.y, box.low.y, box.high.y),
                    std::clamp(point.z, box.low.z, box.high.z)};
  if (square_of(point - inside) >= reach * reach) return;
  if (right != 0) {
    search(node + 1, point, reach, found);
    search(right, point, reach, found);
    return;
  }
  bool on_face = false;
  for (std::uint32_t k = begin; k < end; ++k) {
    const Vec3 apart = point - nearest_point(facets_[order_[k]].corner, point, on_face);
    if (square_of(apart) < reach * reach) found.push_back(order_[k]);
  }
}

void SurfaceMesh::add_near(const Vec3& point, double reach,
                           std::vector<std::uint32_t>& found) const {
  if (nodes_.empty()) return;
  const auto first = static_cast<std::ptrdiff_t>(found.size());
  search(0, point, reach, found);
  std::sort(found.begin() + first, found.end());
}

// --------------------------------------------------------------------------------------- contacts

// On the face the distance is that from the plane, whose normal does not depend on where on it.
SurfaceMesh::Foot SurfaceMesh::foot_on(std::uint32_t triangle, const Vec3& point) const {
  const Facet& facet = facets_[triangle];
  Foot foot;
  foot.triangle = triangle;
  bool on_face = false;
  foot.point = nearest_point(facet.corner, point, on_face);
  const double height = dot(point - facet.corner[0], facet.normal);
  foot.normal = height < 0 ? -facet.normal : facet.normal;
  foot.distance = std::abs(height);
  if (on_face) return foot;
  const Vec3 apart = point - foot.point;
  foot.distance = norm(apart);
  if (foot.distance > 0) foot.normal = apart * (1 / foot.distance);
  return foot;
}

// Not a minimum: another triangle comes nearer and runs through this foot, so that the way along it
// leads down (the distance from a point is convex on a triangle).
bool SurfaceMesh::is_minimum(const Foot& foot, std::span<const Foot> feet, double radius) const {
  return std::none_of(feet.begin(), feet.end(), [&](const Foot& other) {
    if (other.triangle == foot.triangle || other.distance >= foot.distance) return false;
    bool on_face = false;
    const Vec3 apart =
        foot.point - nearest_point(facets_[other.triangle].corner, foot.point, on_face);
    return square_of(apart) <= (kOnTriangle * radius) * (kOnTriangle * radius);
  });
}

TouchList SurfaceMesh::touches(const Vec3& centre, double radius,
                               std::span<const std::uint32_t> near, std::vector<Foot>& feet) const {
  TouchList list;
  feet.clear();
  for (const std::uint32_t triangle : near) {
    const Facet& facet = facets_[triangle];
    double distance = std::abs(dot(centre - facet.corner[0], facet.normal));
    if (distance < radius) {
      const Foot foot = foot_on(triangle, centre);
      distance = foot.distance;
      if (distance < radius) feet.push_back(foot);
    }
    if (distance >= radius) list.room = std::min(list.room, distance - radius);
  }
  std::sort(feet.begin(), feet.end(), [](const Foot& l, const Foot& r) {
    return l.distance != r.distance ? l.distance < r.distance : l.triangle < r.triangle;
  });
  for (const Foot& foot : feet) {
    if (list.count == kMostTouches) break;
    const auto found = list.all();
    const bool is_known = std::any_of(found.begin(), found.end(), [&](const SurfaceTouch& touch) {
      return dot(touch.normal, foot.normal) > kOneSurface;
    });
    if (is_known || !is_minimum(foot, feet, radius)) continue;
    list.touch[list.count++] = {foot.normal, radius - foot.distance};
  }
  return list;
}

}  // namespace granary::dem
