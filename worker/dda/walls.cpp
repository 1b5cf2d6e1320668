#include "worker/dda/walls.h"

#include <algorithm>
#include <cassert>

namespace granary::dda {
namespace {

constexpr std::size_t kRunLength = 8;

WallRun enclose(std::span<const WallSegment> segments, std::size_t first, std::size_t count) {
  const Vec2 from = segments[first].begin, to = segments[first + count - 1].end;
  WallRun run{static_cast<std::int32_t>(first), static_cast<std::int32_t>(count), 0.5 * (from + to),
              0, segments[first].moves};
  for (std::size_t k = first; k < first + count; ++k)
    run.radius = std::max(
        {run.radius, length(segments[k].begin - run.centre), length(segments[k].end - run.centre)});
  return run;
}

std::optional<WallTouch> touch_point(Vec2 point, Vec2 centre_start, Vec2 centre_end,
                                     double radius) {
  const Vec2 start = point - centre_start, end = point - centre_end;
  const double distance_start = length(start), distance_end = length(end);
  // A prediction that swings round the point says nothing about the side the disk comes from.
  const bool turned = dot(start, end) < 0.5 * distance_start * distance_end;
  const Vec2 base = turned ? start : end;
  const double distance = turned ? distance_start : distance_end;
  if (distance == 0) return {};
  const Vec2 normal = (1 / distance) * base;
  return WallTouch{point, normal, distance_start - radius, dot(normal, end) - radius};
}

}  // namespace

void Walls::add_chain(std::span<const Vec2> points, bool moves) {
  assert(points.size() >= 2);
  const std::size_t first = segments.size();
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vec2 along = points[k + 1] - points[k];
    const double size = length(along);
    const auto index = static_cast<std::int32_t>(segments.size());
    segments.push_back({points[k], points[k + 1], (1 / size) * along, size, k > 0 ? index - 1 : -1,
                        k + 2 < points.size() ? index + 1 : -1, moves});
  }
  for (std::size_t k = first; k < segments.size(); k += kRunLength)
    runs.push_back(enclose(segments, k, std::min(kRunLength, segments.size() - k)));
}

std::optional<WallTouch> touch_segment(const std::vector<WallSegment>& segments, std::int32_t index,
                                       Vec2 centre_start, Vec2 centre_end, double radius) {
  const WallSegment& segment = segments[static_cast<std::size_t>(index)];
  const double along = dot(centre_end - segment.begin, segment.tangent);
  if (along < 0) {
    if (segment.previous >= 0) return {};  // flank or joint of the previous segment
    return touch_point(segment.begin, centre_start, centre_end, radius);
  }
  if (along > segment.length) {
    if (segment.next >= 0) {
      const WallSegment& next = segments[static_cast<std::size_t>(segment.next)];
      if (dot(centre_end - next.begin, next.tangent) > 0) return {};
    }
    return touch_point(segment.end, centre_start, centre_end, radius);
  }
  const double offset_start = cross(segment.tangent, centre_start - segment.begin);
  const double offset_end = cross(segment.tangent, centre_end - segment.begin);
  const double side = offset_start < 0 ? -1 : 1;
  return WallTouch{segment.begin + along * segment.tangent,
                   {side * segment.tangent.y, -side * segment.tangent.x},
                   side * offset_start - radius,
                   side * offset_end - radius};
}

double distance_to_segment(const WallSegment& segment, Vec2 point) {
  const double along = std::clamp(dot(point - segment.begin, segment.tangent), 0.0, segment.length);
  return length(point - (segment.begin + along * segment.tangent));
}

}  // namespace granary::dda
