// Reads STL files, ASCII and binary (told apart by the size that a binary header promises). Strict:
// a number that is none, a file that ends early, a triangle without area gives one line that says
// where.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "proto/contract/result.h"

namespace granary {

inline constexpr std::size_t kMaxStlBytes = 32u << 20;
inline constexpr std::size_t kMaxTriangles = 20000;  // of one scene

using TriangleCorners = std::array<double, 9>;  // x, y, z of three corners

// Normals in the file are not used. `what` goes before the error, e.g. "gate.stl".
Result<std::vector<TriangleCorners>> parse_stl(std::string_view bytes, std::string_view what);

// False where the corners lie on one line, as far as their digits tell.
bool has_area(const TriangleCorners& corners);

}  // namespace granary
