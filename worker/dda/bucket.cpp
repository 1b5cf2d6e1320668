#include "worker/dda/bucket.h"

#include <cmath>

namespace granary::dda {
namespace {

// Curved walls become this many chords. With a total turning angle T a sliding disk loses about
// T^2 / (2 n) of its energy at the joints: 0.3 % at one radian.
constexpr int kChordCount = 160;

Vec2 bernstein4(const std::array<Vec2, 5>& point, double s) {
  const double q = 1 - s;
  const double weight[5] = {q * q * q * q, 4 * s * q * q * q, 6 * s * s * q * q, 4 * s * s * s * q,
                            s * s * s * s};
  Vec2 sum;
  for (std::size_t k = 0; k < 5; ++k) sum = sum + weight[k] * point[k];
  return sum;
}

}  // namespace

BucketGeometry make_bucket(std::span<const Vec2> outer_wall, const InnerWall& inner,
                           double pulley_radius) {
  const Vec2 foot{-pulley_radius, 0};
  BucketGeometry bucket;
  for (const Vec2 point : outer_wall) bucket.outer_wall.push_back(foot + point);
  bucket.inner_wall = {foot, foot + Vec2{0, inner.height}};
  if (inner.deflector > 0)
    bucket.inner_wall.push_back(
        bucket.inner_wall.back() +
        inner.deflector * Vec2{-std::sin(inner.deflector_angle), std::cos(inner.deflector_angle)});
  bucket.polygon = bucket.outer_wall;
  for (std::size_t k = bucket.inner_wall.size() - 1; k > 0; --k)
    bucket.polygon.push_back(bucket.inner_wall[k]);
  return bucket;
}

std::vector<Vec2> straight_wall(Vec2 tip) {
  return {{0, 0}, tip};
}

std::vector<Vec2> bezier_wall(const std::array<double, 3>& abscissae, Vec2 tip) {
  const std::array<Vec2, 5> control = {Vec2{0, 0}, Vec2{abscissae[0], tip.y / 4},
                                       Vec2{abscissae[1], tip.y / 2},
                                       Vec2{abscissae[2], 3 * tip.y / 4}, tip};
  std::vector<Vec2> wall;
  for (int k = 0; k <= kChordCount; ++k)
    wall.push_back(bernstein4(control, static_cast<double>(k) / kChordCount));
  return wall;
}

std::vector<Vec2> logarithmic_wall(Vec2 tip, double pulley_radius) {
  const Vec2 from{-pulley_radius, 0}, to = from + tip;
  const double growth = std::log(length(to) / length(from));
  const double turn = std::atan2(cross(from, to), dot(from, to));
  std::vector<Vec2> wall;
  for (int k = 0; k <= kChordCount; ++k) {
    const double s = static_cast<double>(k) / kChordCount;
    const RigidPose spin = RigidPose::rotated(s * turn);
    wall.push_back(std::exp(s * growth) * spin.turn(from) - from);
  }
  return wall;
}

std::vector<Vec2> t_type_wall(Vec2 tip) {
  return bezier_wall({0.75 * tip.x, 0.35 * tip.x, 0.45 * tip.x}, tip);
}

}  // namespace granary::dda
