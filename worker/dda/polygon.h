// Closed polygons: the last point joins the first.
#pragma once

#include <span>

#include "worker/dda/rigid_pose.h"

namespace granary::dda {

double polygon_area(std::span<const Vec2> polygon);
bool polygon_contains(std::span<const Vec2> polygon, Vec2 point);
// Whether the straight way from one point to another touches the polygon's inside.
bool enters_polygon(std::span<const Vec2> polygon, Vec2 from, Vec2 to);

}  // namespace granary::dda
