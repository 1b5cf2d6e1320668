// How fast disks move against their neighbours, and how far they have strayed against them from
// where their velocities led. Disks are grouped by square cells; two from the same or from adjacent
// cells differ by no more than the extent of the vectors found in the two cells together. Common
// motion - the turning bucket, a cloud in flight, a sliding plug - costs nothing.
//
// Pairs from cells further apart are covered by a time limit: coarser and coarser cells, each level
// with the free distance that the cells below guarantee and the relative speeds found in it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/dda/rigid_pose.h"

namespace granary::dda {

class MotionGroups {
 public:
  void group(std::span<const Vec2> position, double cell);  // forgets the speeds
  // Speeds of the groups; bodies closer than `reach` may touch. Precondition: reach < cell.
  void note_speeds(std::span<const Vec2> velocity, double reach);
  // Bound on the speed of a disk against any other of its own and of adjacent cells [m/s].
  double relative_speed(std::size_t disk) const {
    return speed_[static_cast<std::size_t>(finest_.group_of[disk])];
  }
  double largest_relative_speed() const;
  // Pairs that began in cells further apart cannot touch before [s].
  double time_limit() const { return time_limit_; }
  // Do all vectors from the same or from adjacent cells differ by less than `allowed` +
  // `time` x the relative speed of the cells? A vector with NaN is passed over.
  bool agree(std::span<const Vec2> vectors, double allowed, double time);

 private:
  struct Extent {
    double x_min, y_min, x_max, y_max;
    void clear();
    void add(Vec2 v);
    void add(const Extent& other);
    double diagonal2() const;
  };
  struct Level {
    std::vector<std::int32_t> group_of;             // per disk; per group of the finer level
    std::vector<std::int32_t> cell_x, cell_y;       // per group
    std::vector<std::array<std::int32_t, 4>> next;  // per group: E, NW, N, NE; -1 = empty
  };
  void gather(std::span<const Vec2> vectors);
  void join_cells(Level& level, std::size_t member_count);
  double widest_union(const Level& level, const std::vector<Extent>& extent);
  void coarsen();

  Level finest_, coarse_, coarser_;
  double cell_ = 0, time_limit_ = 0;
  std::vector<double> speed_;  // per group
  // Scratch.
  std::vector<Extent> extent_, coarse_extent_, coarser_extent_;
  std::vector<std::int32_t> member_x_, member_y_;
  std::vector<std::int64_t> keys_;
  std::vector<std::int32_t> slots_;
};

}  // namespace granary::dda
