// Geometry of the bucket (PHYSICS section E 2), in world coordinates at theta = 0: the inner wall
// on x = -R from y = 0 upwards with its deflector, the outer wall from (-R, 0) to the tip, and the
// polygon that the mouth line closes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "worker/dda/polygon.h"

namespace granary::dda {

struct BucketGeometry {
  std::vector<Vec2> outer_wall;  // foot -> tip
  std::vector<Vec2> inner_wall;  // foot -> top of the deflector
  std::vector<Vec2> polygon;     // closed: the last point joins the first

  double area() const { return polygon_area(polygon); }
  bool contains(Vec2 point) const { return polygon_contains(polygon, point); }
};

struct InnerWall {
  double height = 0.4;         // m
  double deflector = 0;        // m, beyond the height
  double deflector_angle = 0;  // rad, turned outwards (to -x); 0 = straight on
};

// `outer_wall` relative to the foot of the inner wall, foot first.
BucketGeometry make_bucket(std::span<const Vec2> outer_wall, const InnerWall& inner,
                           double pulley_radius);

// Outer walls relative to the foot (0, 0).
std::vector<Vec2> straight_wall(Vec2 tip);
// Eq. 11: degree 4, control points (0,0), (x2, y/4), (x3, y/2), (x4, 3y/4), tip.
std::vector<Vec2> bezier_wall(const std::array<double, 3>& abscissae, Vec2 tip);
// Logarithmic spiral about the pulley centre from the foot to the tip: the angle between wall and
// radius is the same everywhere.
std::vector<Vec2> logarithmic_wall(Vec2 tip, double pulley_radius);
// Double curvature: concave at the bottom, turning outwards to the tip.
std::vector<Vec2> t_type_wall(Vec2 tip);

}  // namespace granary::dda
