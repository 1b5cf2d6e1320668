// Grains in cell order, cut into blocks of whole slabs across the stream: contacts of a block reach
// into itself and the first slab of the next one, nowhere else. The cut depends on the grains only.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/core/cell_grid.h"
#include "worker/dem/kernels.h"
#include "worker/dem/records.h"

namespace granary::dem {

struct BlockRange {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::uint32_t first_slab = 0;  // slabs [first_slab, end_slab)
  std::uint32_t end_slab = 0;
  std::uint32_t outflow = 0;  // grains of the next block's first slab
};

class CellOrder {
 public:
  // `reach`: largest distance of a pair [m].
  void build(std::span<const GrainMotion> motion, double reach);
  // What distances lose when coordinates are kept in float: the search must reach farther by this
  // [m].
  double rounding() const { return rounding_; }

  // order()[new place] = old place.
  std::span<const std::uint32_t> order() const { return grid_.order(); }
  std::vector<BlockRange> cut(std::size_t grains_per_block) const;

  // Coordinates of the sorted grains for the search, relative to the lowest corner. Call after
  // sorting.
  void load_coordinates(std::span<const GrainMotion> motion, std::span<const GrainSurface> surface);
  // Cells of a slab, in order, ready for the search kernel; only outputs are left to fill in.
  // Returns false where a cell is empty.
  bool cell_task(std::uint32_t slab, std::uint32_t y, std::uint32_t z, SearchTask& task) const;
  std::uint32_t cells_across() const { return static_cast<std::uint32_t>(grid_.counts()[1]); }
  std::uint32_t cells_up() const { return static_cast<std::uint32_t>(grid_.counts()[2]); }
  // Partners that the search may return for the cell, at most.
  static std::size_t most_pairs(const SearchTask& task);

 private:
  core::CellGrid grid_;
  std::vector<core::Vec3> points_;
  std::vector<float> x_, y_, z_, radius_;
  double rounding_ = 0;
};

}  // namespace granary::dem
