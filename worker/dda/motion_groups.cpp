#include "worker/dda/motion_groups.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace granary::dda {
namespace {

constexpr int kCoarseningBits = 1;        // cells double from level to level
constexpr double kUnforeseenSpeed = 0.5;  // m/s, that collisions may add to relative motion
constexpr std::int64_t kNoKey = std::numeric_limits<std::int64_t>::min();

std::int64_t key_of(std::int32_t x, std::int32_t y) {
  return static_cast<std::int64_t>(x) * (std::int64_t{1} << 32) + y;
}

// Open addressing: the place of `key`, or the empty place where it belongs.
std::size_t place_of(const std::vector<std::int64_t>& keys, std::int64_t key) {
  const std::size_t mask = keys.size() - 1;
  std::size_t place = (static_cast<std::uint64_t>(key) * 0x9e3779b97f4a7c15u >> 32) & mask;
  while (keys[place] != kNoKey && keys[place] != key) place = (place + 1) & mask;
  return place;
}

}  // namespace

void MotionGroups::Extent::clear() {
  constexpr double far = std::numeric_limits<double>::infinity();
  *this = {far, far, -far, -far};
}

void MotionGroups::Extent::add(Vec2 v) {
  x_min = std::min(x_min, v.x), x_max = std::max(x_max, v.x);
  y_min = std::min(y_min, v.y), y_max = std::max(y_max, v.y);
}

void MotionGroups::Extent::add(const Extent& other) {
  x_min = std::min(x_min, other.x_min), x_max = std::max(x_max, other.x_max);
  y_min = std::min(y_min, other.y_min), y_max = std::max(y_max, other.y_max);
}

double MotionGroups::Extent::diagonal2() const {
  if (x_max < x_min) return 0;  // empty
  return (x_max - x_min) * (x_max - x_min) + (y_max - y_min) * (y_max - y_min);
}

// Groups the members by their cells (member_x_, member_y_).
void MotionGroups::join_cells(Level& level, std::size_t member_count) {
  keys_.assign(std::bit_ceil(2 * member_count + 2), kNoKey);
  slots_.resize(keys_.size());
  level.group_of.resize(member_count);
  level.cell_x.clear();
  level.cell_y.clear();
  for (std::size_t k = 0; k < member_count; ++k) {
    const std::int32_t x = member_x_[k], y = member_y_[k];
    const std::size_t place = place_of(keys_, key_of(x, y));
    if (keys_[place] == kNoKey) {
      keys_[place] = key_of(x, y);
      slots_[place] = static_cast<std::int32_t>(level.cell_x.size());
      level.cell_x.push_back(x);
      level.cell_y.push_back(y);
    }
    level.group_of[k] = slots_[place];
  }
  level.next.resize(level.cell_x.size());
  for (std::size_t g = 0; g < level.next.size(); ++g) {
    const auto neighbour = [&](std::int32_t dx, std::int32_t dy) {
      const std::size_t place = place_of(keys_, key_of(level.cell_x[g] + dx, level.cell_y[g] + dy));
      return keys_[place] == kNoKey ? -1 : slots_[place];
    };
    level.next[g] = {neighbour(1, 0), neighbour(-1, 1), neighbour(0, 1), neighbour(1, 1)};
  }
}

void MotionGroups::group(std::span<const Vec2> position, double cell) {
  cell_ = cell;
  const double inverse = 1 / cell;
  member_x_.resize(position.size());
  member_y_.resize(position.size());
  for (std::size_t k = 0; k < position.size(); ++k) {
    member_x_[k] = static_cast<std::int32_t>(std::floor(position[k].x * inverse));
    member_y_[k] = static_cast<std::int32_t>(std::floor(position[k].y * inverse));
  }
  join_cells(finest_, position.size());
}

void MotionGroups::gather(std::span<const Vec2> vectors) {
  extent_.resize(finest_.next.size());
  for (Extent& extent : extent_) extent.clear();
  for (std::size_t k = 0; k < vectors.size(); ++k)
    extent_[static_cast<std::size_t>(finest_.group_of[k])].add(vectors[k]);
}

double MotionGroups::widest_union(const Level& level, const std::vector<Extent>& extent) {
  double widest2 = 0;
  for (std::size_t g = 0; g < extent.size(); ++g) {
    widest2 = std::max(widest2, extent[g].diagonal2());
    for (const std::int32_t other : level.next[g]) {
      if (other < 0) continue;
      Extent both = extent[g];
      both.add(extent[static_cast<std::size_t>(other)]);
      widest2 = std::max(widest2, both.diagonal2());
    }
  }
  return std::sqrt(widest2);
}

// coarse_ <- the cells of coarse_, joined into larger ones.
void MotionGroups::coarsen() {
  const std::size_t count = coarse_.cell_x.size();
  member_x_.resize(count);
  member_y_.resize(count);
  for (std::size_t g = 0; g < count; ++g) {
    member_x_[g] = coarse_.cell_x[g] >> kCoarseningBits;
    member_y_[g] = coarse_.cell_y[g] >> kCoarseningBits;
  }
  join_cells(coarser_, count);
  coarser_extent_.resize(coarser_.next.size());
  for (Extent& extent : coarser_extent_) extent.clear();
  for (std::size_t g = 0; g < count; ++g)
    coarser_extent_[static_cast<std::size_t>(coarser_.group_of[g])].add(coarse_extent_[g]);
  std::swap(coarse_, coarser_);
  std::swap(coarse_extent_, coarser_extent_);
}

void MotionGroups::note_speeds(std::span<const Vec2> velocity, double reach) {
  gather(velocity);
  speed_.assign(extent_.size(), 0);
  for (std::size_t g = 0; g < extent_.size(); ++g) {
    speed_[g] = std::max(speed_[g], std::sqrt(extent_[g].diagonal2()));
    for (const std::int32_t next : finest_.next[g]) {
      if (next < 0) continue;
      const auto other = static_cast<std::size_t>(next);
      Extent both = extent_[g];
      both.add(extent_[other]);
      const double speed = std::sqrt(both.diagonal2());
      speed_[g] = std::max(speed_[g], speed);
      speed_[other] = std::max(speed_[other], speed);
    }
  }
  // Not adjacent at one level = at least one of its cells apart.
  time_limit_ = std::numeric_limits<double>::infinity();
  coarse_ = finest_;
  coarse_extent_ = extent_;
  for (double apart = cell_; coarse_.cell_x.size() > 1; apart *= 1 << kCoarseningBits) {
    coarsen();
    const double speed = widest_union(coarse_, coarse_extent_) + kUnforeseenSpeed;
    time_limit_ = std::min(time_limit_, (apart - reach) / speed);
    // Cells left and right of zero never join: stop when all are adjacent.
    const auto [x_low, x_high] = std::minmax_element(coarse_.cell_x.begin(), coarse_.cell_x.end());
    const auto [y_low, y_high] = std::minmax_element(coarse_.cell_y.begin(), coarse_.cell_y.end());
    if (*x_high - *x_low <= 1 && *y_high - *y_low <= 1) break;
  }
}

double MotionGroups::largest_relative_speed() const {
  return speed_.empty() ? 0 : *std::max_element(speed_.begin(), speed_.end());
}

bool MotionGroups::agree(std::span<const Vec2> vectors, double allowed, double time) {
  gather(vectors);
  for (std::size_t g = 0; g < extent_.size(); ++g) {
    const double own = allowed + time * speed_[g];
    if (extent_[g].diagonal2() >= own * own) return false;
    for (const std::int32_t next : finest_.next[g]) {
      if (next < 0) continue;
      const auto other = static_cast<std::size_t>(next);
      Extent both = extent_[g];
      both.add(extent_[other]);
      const double mean = allowed + time * (speed_[g] + speed_[other]) / 2;
      if (both.diagonal2() >= mean * mean) return false;
    }
  }
  return true;
}

}  // namespace granary::dda
