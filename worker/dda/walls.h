// Walls: open chains of straight segments, touched from both sides, each tied to the bucket or
// fixed. Bucket walls are given in bucket coordinates (= world coordinates at theta = 0).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/dda/rigid_pose.h"

namespace granary::dda {

struct WallSegment {
  Vec2 begin, end;
  Vec2 tangent;  // unit, begin -> end
  double length = 0;
  std::int32_t previous = -1;  // neighbours in the chain, -1 at its ends
  std::int32_t next = -1;
  bool moves = false;  // with the bucket
};

// A run of consecutive segments inside one circle, for the neighbour search.
struct WallRun {
  std::int32_t first = 0;
  std::int32_t count = 0;
  Vec2 centre;
  double radius = 0;
  bool moves = false;
};

struct Walls {
  std::vector<WallSegment> segments;
  std::vector<WallRun> runs;

  // Precondition: at least two points, neighbours apart.
  void add_chain(std::span<const Vec2> points, bool moves);
};

// Where a disk touches a segment, in the segment's own frame.
struct WallTouch {
  Vec2 point;            // on the wall
  Vec2 normal;           // unit, from the disk into the wall
  double gap_start = 0;  // m, at the positions of the start of the step
  double gap_end = 0;    // m, along `normal` at the predicted positions
};

// Contact of a disk (centre relative to the wall at the start and predicted at the end of the step)
// with one segment. A joint of two segments is claimed by exactly one of them, and only where
// neither flank is nearer; nullopt = this segment claims nothing.
std::optional<WallTouch> touch_segment(const std::vector<WallSegment>& segments, std::int32_t index,
                                       Vec2 centre_start, Vec2 centre_end, double radius);

double distance_to_segment(const WallSegment& segment, Vec2 point);

}  // namespace granary::dda
