#include "worker/dda/pair_search.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace granary::dda {
namespace {

std::int32_t cell_of(double position, double inverse_cell) {
  return static_cast<std::int32_t>(std::floor(position * inverse_cell));
}

std::uint32_t hash_cell(std::int32_t x, std::int32_t y) {
  const std::uint32_t h =
      static_cast<std::uint32_t>(x) * 0x9e3779b1u ^ static_cast<std::uint32_t>(y) * 0x85ebca77u;
  return h ^ (h >> 15);
}

// Smallest distance over the horizon, assuming straight relative motion, within the two reaches?
bool comes_near(const SweptDisk& a, const SweptDisk& b, double horizon) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double ux = b.vx - a.vx, uy = b.vy - a.vy;
  const double closing = -(dx * ux + dy * uy);
  const double speed2 = ux * ux + uy * uy;
  const double time = closing <= 0 ? 0 : (closing >= horizon * speed2 ? horizon : closing / speed2);
  const double x = dx + time * ux, y = dy + time * uy;
  const double reach = a.reach + b.reach;
  return x * x + y * y < reach * reach;
}

}  // namespace

void PairSearch::sweep_boxes(std::span<const SweptDisk> disks, double horizon) {
  boxes_.resize(disks.size());
  for (std::size_t k = 0; k < disks.size(); ++k) {
    const SweptDisk& d = disks[k];
    const double sx = horizon * d.vx, sy = horizon * d.vy;
    boxes_[k] = {d.x + std::min(sx, 0.0) - d.reach, d.y + std::min(sy, 0.0) - d.reach,
                 d.x + std::max(sx, 0.0) + d.reach, d.y + std::max(sy, 0.0) + d.reach};
  }
}

void PairSearch::hash_boxes(double cell) {
  const double inverse = 1 / cell;
  unsorted_.clear();
  for (std::size_t k = 0; k < boxes_.size(); ++k) {
    const Box& box = boxes_[k];
    const std::int32_t x0 = cell_of(box.x_min, inverse), x1 = cell_of(box.x_max, inverse);
    const std::int32_t y0 = cell_of(box.y_min, inverse), y1 = cell_of(box.y_max, inverse);
    for (std::int32_t y = y0; y <= y1; ++y)
      for (std::int32_t x = x0; x <= x1; ++x)
        unsorted_.push_back({x, y, static_cast<std::int32_t>(k)});
  }
  const std::size_t bucket_count = std::bit_ceil(unsorted_.size() + 1);
  bucket_start_.assign(bucket_count + 1, 0);
  hash_.resize(unsorted_.size());
  for (std::size_t e = 0; e < unsorted_.size(); ++e) {
    hash_[e] = hash_cell(unsorted_[e].cell_x, unsorted_[e].cell_y) &
               static_cast<std::uint32_t>(bucket_count - 1);
    ++bucket_start_[hash_[e] + 1];
  }
  for (std::size_t b = 0; b < bucket_count; ++b) bucket_start_[b + 1] += bucket_start_[b];
  entries_.resize(unsorted_.size());
  for (std::size_t e = unsorted_.size(); e-- > 0;)
    entries_[--bucket_start_[hash_[e] + 1]] = unsorted_[e];
  // bucket_start_[b + 1] now is the start of bucket b, and the entries keep their order.
}

void PairSearch::pair_bucket(std::span<const SweptDisk> disks, std::size_t begin, std::size_t end,
                             double horizon, double cell, std::vector<DiskPair>& pairs) const {
  const double inverse = 1 / cell;
  for (std::size_t e = begin; e < end; ++e) {
    const Entry& one = entries_[e];
    const Box& a = boxes_[static_cast<std::size_t>(one.disk)];
    for (std::size_t f = e + 1; f < end; ++f) {
      const Entry& other = entries_[f];
      if (other.cell_x != one.cell_x || other.cell_y != one.cell_y) continue;
      const Box& b = boxes_[static_cast<std::size_t>(other.disk)];
      const double x_low = std::max(a.x_min, b.x_min), y_low = std::max(a.y_min, b.y_min);
      if (x_low > std::min(a.x_max, b.x_max) || y_low > std::min(a.y_max, b.y_max)) continue;
      // Boxes that share several cells are paired in the lowest one only.
      if (cell_of(x_low, inverse) != one.cell_x || cell_of(y_low, inverse) != one.cell_y) continue;
      const SweptDisk& p = disks[static_cast<std::size_t>(one.disk)];
      const SweptDisk& q = disks[static_cast<std::size_t>(other.disk)];
      if (comes_near(p, q, horizon))
        pairs.push_back({std::min(p.index, q.index), std::max(p.index, q.index)});
    }
  }
}

void PairSearch::find(std::span<const SweptDisk> disks, double horizon, double cell,
                      std::vector<DiskPair>& pairs) {
  pairs.clear();
  sweep_boxes(disks, horizon);
  hash_boxes(cell);
  const std::size_t bucket_count = bucket_start_.size() - 1;
  for (std::size_t b = 0; b < bucket_count; ++b) {
    const std::size_t begin = bucket_start_[b + 1];
    const std::size_t end = b + 2 <= bucket_count ? bucket_start_[b + 2] : entries_.size();
    if (end - begin > 1) pair_bucket(disks, begin, end, horizon, cell, pairs);
  }
}

}  // namespace granary::dda
