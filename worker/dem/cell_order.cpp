#include "worker/dem/cell_order.h"

#include <algorithm>

namespace granary::dem {
namespace {

// Two coordinates are rounded to half an ulp of the extent, squares and roots add as much again.
constexpr double kRounding = 8 * 0x1p-24;

}  // namespace

void CellOrder::build(std::span<const GrainMotion> motion, double reach) {
  points_.resize(motion.size());
  core::Vec3 low, high;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const double* p = motion[k].position;
    points_[k] = {p[0], p[1], p[2]};
    if (k == 0) low = high = points_[0];
    low = {std::min(low.x, p[0]), std::min(low.y, p[1]), std::min(low.z, p[2])};
    high = {std::max(high.x, p[0]), std::max(high.y, p[1]), std::max(high.z, p[2])};
  }
  rounding_ = kRounding * norm(high - low);
  grid_.build(points_, reach + rounding_);
}

std::vector<BlockRange> CellOrder::cut(std::size_t grains_per_block) const {
  std::vector<BlockRange> blocks;
  const auto counts = grid_.counts();
  const auto slab = [&](std::int32_t x) {
    return grid_.range_of(grid_.index({x, 0, 0}), grid_.index({x, counts[1] - 1, counts[2] - 1}));
  };
  BlockRange block;
  for (std::int32_t x = 0; x < counts[0]; ++x) {
    const auto [begin, end] = slab(x);
    if (block.count == 0) block.first = begin;
    block.count += end - begin;
    block.end_slab = static_cast<std::uint32_t>(x) + 1;
    if (block.count < grains_per_block && x + 1 < counts[0]) continue;
    if (x + 1 < counts[0]) {
      const auto [next_begin, next_end] = slab(x + 1);
      block.outflow = next_end - next_begin;
    }
    if (block.count > 0) blocks.push_back(block);
    block = {};
    block.first_slab = static_cast<std::uint32_t>(x) + 1;
  }
  return blocks;
}

void CellOrder::load_coordinates(std::span<const GrainMotion> motion,
                                 std::span<const GrainSurface> surface) {
  const std::size_t padded = motion.size() + kLanes;
  x_.resize(padded);
  y_.resize(padded);
  z_.resize(padded);
  radius_.resize(padded);
  const core::Vec3 low = grid_.origin();
  for (std::size_t k = 0; k < motion.size(); ++k) {
    x_[k] = static_cast<float>(motion[k].position[0] - low.x);
    y_[k] = static_cast<float>(motion[k].position[1] - low.y);
    z_[k] = static_cast<float>(motion[k].position[2] - low.z);
    radius_[k] = static_cast<float>(surface[k].radius);
  }
}

bool CellOrder::cell_task(std::uint32_t slab, std::uint32_t y, std::uint32_t z,
                          SearchTask& task) const {
  const auto counts = grid_.counts();
  const auto sx = static_cast<std::int32_t>(slab), sy = static_cast<std::int32_t>(y);
  const auto low = std::max(static_cast<std::int32_t>(z) - 1, 0);
  const auto high = std::min(static_cast<std::int32_t>(z) + 1, counts[2] - 1);
  const std::size_t home = grid_.index({sx, sy, static_cast<std::int32_t>(z)});
  const auto own = grid_.range_of(home, home);
  if (own.first == own.second) return false;
  task.x = x_.data();
  task.y = y_.data();
  task.z = z_.data();
  task.radius = radius_.data();
  task.begin = own.first;
  task.end = own.second;
  task.row_end = grid_.range_of(home, grid_.index({sx, sy, high})).second;
  const auto row = [&](int k, std::int32_t x, std::int32_t row_y) {
    task.rows[k][0] = task.rows[k][1] = 0;
    if (x >= counts[0] || row_y < 0 || row_y >= counts[1]) return;
    const auto range = grid_.range_of(grid_.index({x, row_y, low}), grid_.index({x, row_y, high}));
    task.rows[k][0] = range.first;
    task.rows[k][1] = range.second;
  };
  row(0, sx, sy + 1);
  row(1, sx + 1, sy - 1);
  row(2, sx + 1, sy);
  row(3, sx + 1, sy + 1);
  return true;
}

std::size_t CellOrder::most_pairs(const SearchTask& task) {
  std::size_t partners = task.row_end - task.begin;
  for (const auto& row : task.rows) partners += row[1] - row[0];
  return partners * (task.end - task.begin);
}

}  // namespace granary::dem
