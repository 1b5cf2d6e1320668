// Plane rigid motion by its exact finite rotation: the linearised one would dilate the bucket by
// (omega dt)^2 / 2 per step (PHYSICS section A5).
#pragma once

#include <cmath>

namespace granary::dda {

struct Vec2 {
  double x = 0;
  double y = 0;
};

inline Vec2 operator+(Vec2 a, Vec2 b) {
  return {a.x + b.x, a.y + b.y};
}
inline Vec2 operator-(Vec2 a, Vec2 b) {
  return {a.x - b.x, a.y - b.y};
}
inline Vec2 operator*(double s, Vec2 a) {
  return {s * a.x, s * a.y};
}
inline double dot(Vec2 a, Vec2 b) {
  return a.x * b.x + a.y * b.y;
}
inline double cross(Vec2 a, Vec2 b) {
  return a.x * b.y - a.y * b.x;
}
inline double length(Vec2 a) {
  return std::sqrt(dot(a, a));
}

// world = rotation * body + shift
struct RigidPose {
  double cosine = 1;
  double sine = 0;
  Vec2 shift;

  static RigidPose rotated(double angle, Vec2 shift = {}) {  // rad, counter-clockwise
    return {std::cos(angle), std::sin(angle), shift};
  }
  Vec2 turn(Vec2 v) const { return {cosine * v.x - sine * v.y, sine * v.x + cosine * v.y}; }
  Vec2 turn_back(Vec2 v) const { return {cosine * v.x + sine * v.y, cosine * v.y - sine * v.x}; }
  Vec2 to_world(Vec2 body) const { return turn(body) + shift; }
  Vec2 to_body(Vec2 world) const { return turn_back(world - shift); }
};

}  // namespace granary::dda
