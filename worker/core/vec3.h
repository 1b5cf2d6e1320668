// Vectors and matrices of space for set-up and plain kernels: doubles, value semantics, no
// templates. The vector kernels have their own types.
#pragma once

#include <array>
#include <cmath>

namespace granary::core {

struct Vec3 {
  double x = 0;
  double y = 0;
  double z = 0;

  constexpr Vec3& operator+=(const Vec3& o) { return *this = Vec3{x + o.x, y + o.y, z + o.z}; }
  constexpr Vec3& operator-=(const Vec3& o) { return *this = Vec3{x - o.x, y - o.y, z - o.z}; }
  constexpr Vec3& operator*=(double s) { return *this = Vec3{x * s, y * s, z * s}; }
  constexpr bool operator==(const Vec3&) const = default;
};

constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
constexpr Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(Vec3 a, double s) { return a *= s; }
constexpr Vec3 operator*(double s, Vec3 a) { return a *= s; }
constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

struct Mat3 {
  std::array<Vec3, 3> rows{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
};

constexpr Vec3 operator*(const Mat3& m, const Vec3& v) {
  return {dot(m.rows[0], v), dot(m.rows[1], v), dot(m.rows[2], v)};
}
constexpr Mat3 transpose(const Mat3& m) {
  const auto& [a, b, c] = m.rows;
  return {{Vec3{a.x, b.x, c.x}, Vec3{a.y, b.y, c.y}, Vec3{a.z, b.z, c.z}}};
}
constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
  const Mat3 columns = transpose(b);
  Mat3 product;
  for (std::size_t i = 0; i < 3; ++i) {
    product.rows[i] = columns * a.rows[i];
  }
  return product;
}
// Rotation by the angle |rotation| about the direction of `rotation` (Rodrigues).
Mat3 rotation_matrix(const Vec3& rotation);
// (I + [w]x)^-1 = (I - [w]x + w w^T) / (1 + w.w): the implicit half of a Crank-Nicolson rotation.
Mat3 inverse_of_one_plus_cross(const Vec3& w);

}  // namespace granary::core
