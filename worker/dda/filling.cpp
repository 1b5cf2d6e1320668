#include "worker/dda/filling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "worker/core/random.h"
#include "worker/dda/walls.h"

namespace granary::dda {
namespace {

constexpr double kPitch = 1.05;   // of the largest diameter
constexpr double kJitter = 0.02;  // of the largest diameter, to either side: 2 * 0.02 < 0.05
constexpr double kMouthShare =
    0.75;  // width of the array; narrower falls deeper, wider starts higher

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

struct Strip {
  double x_min, x_max, y_min;
};

// Highest point of a polyline between two abscissae.
double highest_within(const std::vector<Vec2>& line, double x_min, double x_max) {
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    Vec2 a = line[k], b = line[k + 1];
    if (a.x > b.x) std::swap(a, b);
    if (b.x < x_min || a.x > x_max) continue;
    const auto height_at = [&](double x) {
      return b.x > a.x ? a.y + (x - a.x) / (b.x - a.x) * (b.y - a.y) : std::max(a.y, b.y);
    };
    highest = std::max({highest, height_at(std::max(a.x, x_min)), height_at(std::min(b.x, x_max))});
  }
  return highest;
}

// The part of the mouth next to the inner wall, down to the outer wall.
Strip drop_strip(const BucketGeometry& bucket, double diameter) {
  double x_max = bucket.inner_wall.back().x;
  for (const Vec2 point : bucket.inner_wall) x_max = std::min(x_max, point.x);
  const double mouth = x_max - bucket.outer_wall.back().x;
  const double x_min = x_max - std::max(kMouthShare * mouth, std::min(mouth, 1.5 * diameter));
  return {x_min, x_max, highest_within(bucket.outer_wall, x_min - diameter / 2, x_max)};
}

bool clear_of(const std::vector<WallSegment>& segments, Vec2 centre, double radius) {
  return std::all_of(segments.begin(), segments.end(), [&](const WallSegment& segment) {
    return distance_to_segment(segment, centre) >= radius;
  });
}

}  // namespace

Disks drop_array(const DiskKind& kind, const BucketGeometry& bucket) {
  const double largest = kind.diameter_max, pitch = kPitch * largest;
  const Strip strip = drop_strip(bucket, largest);
  const auto columns =
      static_cast<std::uint32_t>(std::max(1.0, std::floor((strip.x_max - strip.x_min) / pitch)));
  const std::uint32_t rows = (kind.count + columns - 1) / columns;
  Disks disks;
  for (std::uint32_t k = 0; k < kind.count; ++k) {
    const std::uint32_t row = k / columns;
    const auto jitter = [&](RandomStream stream) {
      return kJitter * largest * (2 * core::random_uniform(kind.seed, stream, k) - 1);
    };
    const Vec2 centre{strip.x_max - (k % columns + 0.5) * pitch + jitter(jitter_x_stream),
                      strip.y_min + (row + 1.0) * pitch + jitter(jitter_y_stream)};
    add_disk(disks, kind, centre, random_diameter(kind, k), row * kStratumCount / rows);
  }
  return disks;
}

Disks compact_order(const DiskKind& kind, const BucketGeometry& bucket) {
  Walls walls;
  walls.add_chain(bucket.outer_wall, true);
  walls.add_chain(bucket.inner_wall, true);
  double x_min = 0, x_max = -std::numeric_limits<double>::infinity(), y_max = x_max;
  for (const Vec2 point : bucket.polygon) {
    x_min = std::min(x_min, point.x);
    x_max = std::max(x_max, point.x);
    y_max = std::max(y_max, point.y);
  }
  const double pitch = kind.diameter_max, rise = pitch * std::sqrt(0.75);
  Disks disks;
  for (std::uint32_t row = 0; disks.count() < kind.count; ++row) {
    const double y = (row + 0.5) * rise;
    if (y > y_max) break;
    for (double x = x_max - pitch * (row % 2 == 0 ? 0.5 : 1.0);
         x > x_min && disks.count() < kind.count; x -= pitch)
      if (bucket.contains({x, y}) && clear_of(walls.segments, {x, y}, pitch / 2))
        add_disk(disks, kind, {x, y},
                 random_diameter(kind, static_cast<std::uint32_t>(disks.count())),
                 static_cast<std::uint32_t>(disks.count() * kStratumCount / kind.count));
  }
  return disks;
}

}  // namespace granary::dda
