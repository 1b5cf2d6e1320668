#include "worker/core/cell_grid.h"

#include <algorithm>
#include <cmath>

namespace granary::core {
namespace {

// What is no number falls into the first cell: its grain is found out by the sentinels, not here.
std::int32_t clamp_cell(double position, std::int32_t count) {
  return position > 0
             ? static_cast<std::int32_t>(std::min(position, static_cast<double>(count - 1)))
             : 0;
}

bool is_finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

double cells_along(double length, double cell_size) {
  return std::max(1.0, std::floor(length / cell_size));
}

double cells_for(const Vec3& extent, double cell_size) {
  return cells_along(extent.x, cell_size) * cells_along(extent.y, cell_size) *
         cells_along(extent.z, cell_size);
}

}  // namespace

void CellGrid::fit_box(std::span<const Vec3> points, double cell_size) {
  const auto first = std::find_if(points.begin(), points.end(), is_finite);
  Vec3 low = first == points.end() ? Vec3{} : *first;
  Vec3 high = low;
  for (const Vec3& p : points) {
    if (!is_finite(p)) continue;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  origin_ = low;
  const Vec3 extent = high - low;
  const double most_cells = 4096 + 16.0 * static_cast<double>(points.size());
  while (cells_for(extent, cell_size) > most_cells) cell_size *= 1.25;
  const auto fit = [&](double length, std::int32_t& count, double& inverse) {
    count = static_cast<std::int32_t>(cells_along(length, cell_size));
    inverse = 1 / std::max(cell_size, length / count);
  };
  fit(extent.x, counts_[0], inverse_size_.x);
  fit(extent.y, counts_[1], inverse_size_.y);
  fit(extent.z, counts_[2], inverse_size_.z);
}

std::array<std::int32_t, 3> CellGrid::coordinates(const Vec3& point) const {
  const Vec3 p = point - origin_;
  return {clamp_cell(p.x * inverse_size_.x, counts_[0]),
          clamp_cell(p.y * inverse_size_.y, counts_[1]),
          clamp_cell(p.z * inverse_size_.z, counts_[2])};
}

void CellGrid::build(std::span<const Vec3> points, double cell_size) {
  fit_box(points, cell_size);
  starts_.assign(static_cast<std::size_t>(counts_[0]) * counts_[1] * counts_[2] + 1, 0);
  std::vector<std::uint32_t> cell_of(points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    cell_of[p] = static_cast<std::uint32_t>(index(coordinates(points[p])));
    ++starts_[cell_of[p] + 1];
  }
  for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
  order_.resize(points.size());
  std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
  for (std::size_t p = 0; p < points.size(); ++p) {
    order_[next[cell_of[p]]++] = static_cast<std::uint32_t>(p);
  }
}

}  // namespace granary::core
