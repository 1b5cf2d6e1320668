// Linked-cell grid in space: points sorted by cell (counting sort), x slowest, so that neighbours
// along the stream stay close in memory. Cells are at least `cell_size` wide; a pair closer than
// that lies in the same or in adjacent cells. Points outside the box fall into its border cells,
// which keeps that property.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "worker/core/vec3.h"

namespace granary::core {

class CellGrid {
 public:
  // Precondition: cell_size > 0. The box is the bounding box of the points. Cells grow where a few
  // far-flung points would ask for many more cells than there are points.
  void build(std::span<const Vec3> points, double cell_size);

  std::array<std::int32_t, 3> counts() const { return counts_; }
  std::size_t cell_count() const { return starts_.empty() ? 0 : starts_.size() - 1; }
  std::array<std::int32_t, 3> coordinates(const Vec3& point) const;
  std::size_t index(const std::array<std::int32_t, 3>& c) const {
    return (static_cast<std::size_t>(c[0]) * counts_[1] + c[1]) * counts_[2] + c[2];
  }
  // Points of one cell, ascending.
  std::span<const std::uint32_t> points_in(std::size_t cell) const {
    return std::span<const std::uint32_t>(order_).subspan(starts_[cell],
                                                          starts_[cell + 1] - starts_[cell]);
  }
  std::span<const std::uint32_t> order() const { return order_; }
  // Places in order() taken by the points of cells [first_cell, last_cell]: begin and end.
  std::pair<std::uint32_t, std::uint32_t> range_of(std::size_t first_cell,
                                                   std::size_t last_cell) const {
    return {starts_[first_cell], starts_[last_cell + 1]};
  }
  const Vec3& origin() const { return origin_; }  // lowest corner of the box

 private:
  void fit_box(std::span<const Vec3> points, double cell_size);

  Vec3 origin_;
  Vec3 inverse_size_;
  std::array<std::int32_t, 3> counts_{};
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> order_;
};

}  // namespace granary::core
