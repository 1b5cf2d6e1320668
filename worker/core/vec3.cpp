#include "worker/core/vec3.h"

namespace granary::core {

Mat3 rotation_matrix(const Vec3& rotation) {
  const double angle = norm(rotation);
  if (angle == 0) return {};
  const Vec3 k = rotation * (1 / angle);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const auto image = [&](const Vec3& v) {
    return v * c + cross(k, v) * s + k * (dot(k, v) * (1 - c));
  };
  return transpose({{image({1, 0, 0}), image({0, 1, 0}), image({0, 0, 1})}});
}

Mat3 inverse_of_one_plus_cross(const Vec3& w) {
  const double scale = 1 / (1 + dot(w, w));
  const auto image = [&](const Vec3& v) { return (v - cross(w, v) + w * dot(w, v)) * scale; };
  return transpose({{image({1, 0, 0}), image({0, 1, 0}), image({0, 0, 1})}});
}

}  // namespace granary::core
