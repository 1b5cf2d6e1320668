#include "worker/dda/filling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "worker/core/random.h"
#include "worker/dda/walls.h"

namespace granary::dda {
namespace {

constexpr double kPitch = 1.05;       // of the largest diameter
constexpr double kJitter = 0.02;      // of the largest diameter, to either side: 2 * 0.02 < 0.05
constexpr double kMouthShare = 0.75;  // width of the rows above the mouth; wider ones spill

enum RandomStream : std::uint64_t { diameter_stream = 1, jitter_x_stream = 2, jitter_y_stream = 3 };

double random_diameter(const DiskKind& kind, std::uint32_t k) {
  return kind.diameter_min + (kind.diameter_max - kind.diameter_min) *
                                 core::random_uniform(kind.seed, diameter_stream, k);
}

void add_disk(Disks& disks, const DiskKind& kind, Vec2 centre, double diameter,
              std::uint32_t stratum) {
  const double radius = diameter / 2;
  const double mass = kind.mass_per_area * std::numbers::pi * radius * radius;
  disks.add({centre.x, centre.y, radius, 0}, {0, 0, 0, 1 / mass}, stratum);
}

struct Bounds {
  double x_min, x_max, y_min, y_max;
};

Bounds bounds_of(const BucketGeometry& bucket) {
  constexpr double far = std::numeric_limits<double>::infinity();
  Bounds bounds{far, -far, far, -far};
  for (const Vec2 point : bucket.polygon) {
    bounds.x_min = std::min(bounds.x_min, point.x);
    bounds.x_max = std::max(bounds.x_max, point.x);
    bounds.y_min = std::min(bounds.y_min, point.y);
    bounds.y_max = std::max(bounds.y_max, point.y);
  }
  return bounds;
}

bool clear_of(const std::vector<WallSegment>& segments, Vec2 centre, double radius) {
  return std::all_of(segments.begin(), segments.end(), [&](const WallSegment& segment) {
    return distance_to_segment(segment, centre) >= radius;
  });
}

}  // namespace

Disks drop_array(const DiskKind& kind, const BucketGeometry& bucket) {
  const double largest = kind.diameter_max, pitch = kPitch * largest;
  Walls walls;
  walls.add_chain(bucket.outer_wall, true);
  walls.add_chain(bucket.inner_wall, true);
  const Bounds inside = bounds_of(bucket);
  const double mouth = bucket.inner_wall.back().x - bucket.outer_wall.back().x;
  const double heap_x_min =
      bucket.inner_wall.back().x - std::max(kMouthShare * mouth, std::min(mouth, 1.5 * largest));
  const double clearance = (0.5 + kJitter * std::numbers::sqrt2) * largest;
  Disks disks;
  for (std::uint32_t row = 0; disks.count() < kind.count; ++row) {
    const std::size_t count_before = disks.count();
    const double y = inside.y_min + (row + 1.0) * pitch;
    const bool above = y > bucket.outer_wall.back().y;
    const double x_min = above ? heap_x_min : inside.x_min;
    const double x_max = above ? bucket.inner_wall.back().x : inside.x_max;
    for (double x = x_max - 0.5 * pitch; x > x_min && disks.count() < kind.count; x -= pitch) {
      if ((!above && !bucket.contains({x, y})) || !clear_of(walls.segments, {x, y}, clearance))
        continue;
      const auto k = static_cast<std::uint32_t>(disks.count());
      const auto jitter = [&](RandomStream stream) {
        return kJitter * largest * (2 * core::random_uniform(kind.seed, stream, k) - 1);
      };
      add_disk(disks, kind, {x + jitter(jitter_x_stream), y + jitter(jitter_y_stream)},
               random_diameter(kind, k), k * kStratumCount / kind.count);
    }
    if (y > inside.y_max + 2 * pitch && disks.count() == count_before)
      throw std::invalid_argument("discharge.bucket: no disk passes through its mouth");
  }
  return disks;
}

Disks compact_order(const DiskKind& kind, const BucketGeometry& bucket) {
  Walls walls;
  walls.add_chain(bucket.outer_wall, true);
  walls.add_chain(bucket.inner_wall, true);
  const Bounds inside = bounds_of(bucket);
  const double pitch = kind.diameter_max, rise = pitch * std::sqrt(0.75);
  Disks disks;
  for (std::uint32_t row = 0; disks.count() < kind.count; ++row) {
    const double y = (row + 0.5) * rise;
    if (y > inside.y_max) break;
    for (double x = inside.x_max - pitch * (row % 2 == 0 ? 0.5 : 1.0);
         x > inside.x_min && disks.count() < kind.count; x -= pitch)
      if (bucket.contains({x, y}) && clear_of(walls.segments, {x, y}, pitch / 2))
        add_disk(disks, kind, {x, y},
                 random_diameter(kind, static_cast<std::uint32_t>(disks.count())),
                 static_cast<std::uint32_t>(disks.count() * kStratumCount / kind.count));
  }
  return disks;
}

}  // namespace granary::dda
