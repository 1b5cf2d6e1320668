// Walls made of triangles. A contact of a sphere with the mesh is a local minimum of the distance
// from its centre to the surface, so that a shared edge or corner pushes once and a flat floor of
// many triangles pushes like one plane; no connectivity is needed, and corners that lie on
// another triangle's edge do no harm. Minima whose normals agree within kOneSurface are one
// contact, the deepest of them: its potential is continuous from facet to facet of a curved wall.
// Triangles act on both sides; the order of their corners means nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "worker/core/vec3.h"
#include "worker/dem/setup.h"

namespace granary::dem {

// Cosine of 10 degrees: facets of one curved wall meet at less, and the normal of a contact turns
// by less in one step.
inline constexpr double kOneSurface = 0.985;
// A sphere in a narrow box touches five sides; what lies shallower than the sixth is left out.
inline constexpr std::size_t kMostTouches = 6;

// Where a grain touches the mesh.
struct SurfaceTouch {
  core::Vec3 normal;   // unit, from the surface to the grain's centre
  double overlap = 0;  // m
};

struct TouchList {
  std::array<SurfaceTouch, kMostTouches> touch;
  std::size_t count = 0;
  // No triangle of the list that is not touched is nearer to the sphere than this [m].
  double room = std::numeric_limits<double>::infinity();
  std::span<const SurfaceTouch> all() const { return {touch.data(), count}; }
};

class SurfaceMesh {
 public:
  // Point of a triangle that is nearest to a sphere's centre, within its radius.
  struct Foot {
    core::Vec3 point;
    core::Vec3 normal;  // unit, towards the centre
    double distance = 0;
    std::uint32_t triangle = 0;
  };

  explicit SurfaceMesh(std::span<const Triangle> triangles);

  bool empty() const { return facets_.empty(); }
  // Appends the triangles closer than `reach` to the point, in ascending order.
  void add_near(const core::Vec3& point, double reach, std::vector<std::uint32_t>& found) const;
  // Contacts of a sphere with the triangles in `near`, deepest first. `feet` is scratch memory.
  // Triangles beyond the radius change nothing: any `near` that holds the touched ones will do.
  TouchList touches(const core::Vec3& centre, double radius, std::span<const std::uint32_t> near,
                    std::vector<Foot>& feet) const;

 private:
  struct Facet {
    core::Vec3 corner[3];
    core::Vec3 normal;  // unit
  };
  struct Box {
    core::Vec3 low, high;
  };
  // Binary tree of boxes; a leaf holds triangles order_[begin .. end), `right` is 0.
  struct Node {
    Box box;
    std::uint32_t begin = 0, end = 0;
    std::uint32_t right = 0;  // the left child follows its parent
  };

  Foot foot_on(std::uint32_t triangle, const core::Vec3& point) const;
  bool is_minimum(const Foot& foot, std::span<const Foot> feet, double radius) const;
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
  Box box_of(std::uint32_t begin, std::uint32_t end) const;
  void search(std::uint32_t node, const core::Vec3& point, double reach,
              std::vector<std::uint32_t>& found) const;

  std::vector<Facet> facets_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

// Tells a grain's contacts apart by their normals: every touch goes to the touching slot whose
// normal is nearest, within kOneSurface, and otherwise to a free one; so springs live on from
// triangle to triangle and around edges. A Slot has `touch`, `touching` and `is_met`, which is set
// here. Touches that find no slot are left out.
template <typename Slot>
void assign_touches(std::span<const SurfaceTouch> touches, std::span<Slot> slots) {
  for (Slot& slot : slots) slot.is_met = false;
  std::array<bool, kMostTouches> is_new = {};
  for (std::size_t k = 0; k < touches.size(); ++k) {
    Slot* best = nullptr;
    double nearest = kOneSurface;
    for (Slot& slot : slots) {
      const double likeness = dot(slot.touch.normal, touches[k].normal);
      if (slot.is_met || !slot.touching || likeness < nearest) continue;
      nearest = likeness;
      best = &slot;
    }
    is_new[k] = best == nullptr;
    if (best == nullptr) continue;
    best->touch = touches[k];
    best->is_met = true;
  }
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (!is_new[k]) continue;
    for (Slot& slot : slots) {
      if (slot.is_met || slot.touching) continue;
      slot.touch = touches[k];
      slot.is_met = true;
      break;
    }
  }
}

}  // namespace granary::dem
