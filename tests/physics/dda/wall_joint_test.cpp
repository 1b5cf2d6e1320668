// Claim: the joints of curved walls do not kick: the energy of a frictionless bead that slides
// along a
//   T-type, a logarithmic or a Bezier wall changes by no more than what stopping or reversing its
//   normal speed at every joint can do, and a wall that bends towards it never throws it off.
// Method: a 2 mm bead without gravity or friction, 1 m/s along each wall at rest, in both
// directions;
//   dt 2e-4 s.
// Reference: energy balance; a chain of n chords that turns by T in all takes T^2 / (2 n) of the
// energy
//   from a bead whose normal speed v T / n every joint stops (bucket.cpp); reversed at every joint
//   it is four times that, and no gain.
// Tolerance: loss 4 T^2 / (2 n); gain and unbooked energy (a joint is met within a step, whose
// normal is
//   fixed) a tenth of it; the bead's distance from an arc: what it flies in one step past a joint.
// Seconds: 0.1
#include <gtest/gtest.h>

#include "tests/physics/dda/textbook.h"
#include "worker/dda/bucket.h"

namespace granary::dda {
namespace {

constexpr double kRadius = 0.001, kSpeed = 1;

struct Slide {
  double most = 0, last = 0;  // kinetic energy / that at the start
  double farthest_off = 0;    // m, gap to the wall on the way
  double remainder = 0;       // of the ledger / kinetic energy at the start
};

double turning(const std::vector<Vec2>& wall) {
  double sum = 0;
  for (std::size_t k = 1; k + 1 < wall.size(); ++k) {
    const Vec2 a = wall[k] - wall[k - 1], b = wall[k + 1] - wall[k];
    sum += std::abs(std::atan2(cross(a, b), dot(a, b)));
  }
  return sum;
}

// `side` +1: on the left of the wall's direction.
Slide slide_along(std::vector<Vec2> wall, bool reversed, double side) {
  if (reversed) {
    std::reverse(wall.begin(), wall.end());
    side = -side;
  }
  System system;
  system.gravity = 0;
  system.walls.add_chain(wall, false);
  const Vec2 along = (1 / length(wall[1] - wall[0])) * (wall[1] - wall[0]);
  const Vec2 off = side * Vec2{-along.y, along.x};
  add_disk(system, wall[0] + 1e-4 * along + kRadius * off, kRadius, 1000);
  system.disks.motion[0].vx = kSpeed * along.x;
  system.disks.motion[0].vy = kSpeed * along.y;
  reset_contacts(system);
  double total = 0;
  for (std::size_t k = 1; k < wall.size(); ++k) total += length(wall[k] - wall[k - 1]);
  Slide slide;
  const double start = system.ledger.kinetic_j;
  while (system.time * kSpeed < total - 2 * kRadius) {
    step(system);
    slide.most = std::max(slide.most, system.ledger.stored_j() / start);
    double gap = 1;
    const Vec2 centre{system.disks.pose[0].x, system.disks.pose[0].y};
    for (const WallSegment& segment : system.walls.segments)
      gap = std::min(gap, distance_to_segment(segment, centre) - kRadius);
    slide.farthest_off = std::max(slide.farthest_off, gap);
  }
  slide.last = system.ledger.stored_j() / start;
  slide.remainder = std::abs(system.ledger.remainder_j()) / start;
  return slide;
}

TEST(WallJoint, neither_kicks_nor_stops_a_sliding_bead) {
  const Vec2 tip{-0.15, 0.15};
  for (const auto& [name, wall] : {std::pair{"T-type", t_type_wall(tip)},
                                   {"logarithmic", logarithmic_wall(tip, 0.5)},
                                   {"bezier", bezier_wall({-0.1, -0.15, -0.16}, tip)}}) {
    const double loss = turning(wall) * turning(wall) / (2 * static_cast<double>(wall.size() - 2));
    for (const bool reversed : {false, true})
      for (const double side : {1.0, -1.0}) {
        const Slide slide = slide_along(wall, reversed, side);
        EXPECT_LT(slide.most, 1 + 0.4 * loss) << name << reversed << side;
        EXPECT_GT(slide.last, 1 - 4 * loss) << name << reversed << side;
        EXPECT_LT(slide.remainder, 0.4 * loss) << name << reversed << side;
      }
  }
}

// On the inside of a circle every joint bends towards the bead: it never leaves the wall.
TEST(WallJoint, keeps_a_bead_on_a_wall_that_bends_towards_it) {
  std::vector<Vec2> arc;
  for (int k = 0; k <= 160; ++k) {
    const double angle = 2.0 * k / 160;
    arc.push_back({0.1 * std::sin(angle), 0.1 - 0.1 * std::cos(angle)});
  }
  const Slide slide = slide_along(arc, false, 1);
  // Half a step before each joint the next chord is ahead: v dt times the turn of a joint.
  EXPECT_LT(slide.farthest_off, kSpeed * 2e-4 * 2.0 / 160 + 1e-7);
  EXPECT_GT(slide.last, 1 - 2 * 4.0 / 320);
}

}  // namespace
}  // namespace granary::dda
