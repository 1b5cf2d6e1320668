#include "worker/dda/polygon.h"

#include <cmath>

namespace granary::dda {
namespace {

bool sides_differ(Vec2 from, Vec2 to, Vec2 a, Vec2 b) {
  return (cross(to - from, a - from) > 0) != (cross(to - from, b - from) > 0);
}

}  // namespace

double polygon_area(std::span<const Vec2> polygon) {
  double doubled = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k)
    doubled += cross(polygon[k], polygon[(k + 1) % polygon.size()]);
  return std::abs(doubled) / 2;
}

// Crossings of a ray to +x, counted half-open in y so that a vertex counts once.
bool polygon_contains(std::span<const Vec2> polygon, Vec2 point) {
  bool inside = false;
  for (std::size_t k = 0, j = polygon.size() - 1; k < polygon.size(); j = k++) {
    const Vec2 a = polygon[k], b = polygon[j];
    if ((a.y > point.y) == (b.y > point.y)) continue;
    if (point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

bool enters_polygon(std::span<const Vec2> polygon, Vec2 from, Vec2 to) {
  if (polygon_contains(polygon, to)) return true;
  for (std::size_t k = 0, j = polygon.size() - 1; k < polygon.size(); j = k++)
    if (sides_differ(from, to, polygon[k], polygon[j]) &&
        sides_differ(polygon[k], polygon[j], from, to))
      return true;
  return false;
}

}  // namespace granary::dda
