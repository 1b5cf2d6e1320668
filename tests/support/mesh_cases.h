// Surfaces cut into triangles, for tests of mesh walls.
#pragma once

#include <vector>

#include "worker/dem/setup.h"

namespace granary::tests {

// The parallelogram corner + s first + t second, cut into columns x rows cells of two triangles;
// their diagonals alternate, so that no two lie in line.
inline std::vector<dem::Triangle> sheet(const core::Vec3& corner, const core::Vec3& first,
                                        const core::Vec3& second, int columns, int rows) {
  std::vector<dem::Triangle> triangles;
  const auto node = [&](int i, int j) {
    return corner + first * (static_cast<double>(i) / columns) +
           second * (static_cast<double>(j) / rows);
  };
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const core::Vec3 a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1),
                       d = node(i, j + 1);
      if ((i + j) % 2 == 0) {
        triangles.push_back({a, b, c});
        triangles.push_back({c, d, a});
      } else {
        triangles.push_back({b, c, d});
        triangles.push_back({a, b, d});
      }
    }
  }
  return triangles;
}

inline void append(std::vector<dem::Triangle>& all, const std::vector<dem::Triangle>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

// The block 0 <= x, y, z <= side, each face cut into cells x cells.
inline std::vector<dem::Triangle> block_mesh(double side, int cells) {
  const core::Vec3 x{side, 0, 0}, y{0, side, 0}, z{0, 0, side}, origin{};
  std::vector<dem::Triangle> all;
  append(all, sheet(origin, x, y, cells, cells));
  append(all, sheet(origin, y, z, cells, cells));
  append(all, sheet(origin, z, x, cells, cells));
  append(all, sheet(z, x, y, cells, cells));
  append(all, sheet(x, y, z, cells, cells));
  append(all, sheet(y, z, x, cells, cells));
  return all;
}

}  // namespace granary::tests
