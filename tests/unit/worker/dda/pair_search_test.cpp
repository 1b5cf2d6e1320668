#include "worker/dda/pair_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "worker/core/random.h"

namespace granary::dda {
namespace {

constexpr double kHorizon = 0.02;

// Positions half-way; `sweep` bounds half of what two of them may move against each other.
std::vector<SearchDisk> random_disks(int count, double speed) {
  std::vector<SearchDisk> disks;
  const auto random = [](std::uint64_t stream, int k) {
    return core::random_uniform(3, stream, k);
  };
  for (int k = 0; k < count; ++k) {
    // One in ten is ten times as fast: it has to look further than its neighbours.
    const double own = k % 10 == 0 ? speed : 0.1 * speed;
    const double vx = own * (random(3, k) - 0.5), vy = own * (random(4, k) - 0.5);
    disks.push_back({random(1, k) - 0.5, random(2, k) - 0.5, vx, vy, 0.01 + 0.01 * random(5, k),
                     std::hypot(vx, vy) * kHorizon / 2, k});
  }
  return disks;
}

// Closest approach sampled densely: an independent, slow answer.
double closest(const SearchDisk& a, const SearchDisk& b) {
  double best = 1e9;
  for (int s = 0; s <= 2000; ++s) {
    const double t = kHorizon * (s / 2000.0 - 0.5);
    best = std::min(best, std::hypot(b.x - a.x + t * (b.vx - a.vx), b.y - a.y + t * (b.vy - a.vy)));
  }
  return best;
}

void expect_every_pair_once(const std::vector<SearchDisk>& disks, double resolution) {
  std::vector<DiskPair> pairs;
  PairSearch().find(disks, kHorizon, pairs);
  std::set<std::pair<int, int>> found;
  for (const DiskPair& pair : pairs) {
    EXPECT_LT(pair.first, pair.second);
    EXPECT_TRUE(found.insert({pair.first, pair.second}).second);
  }
  const int count = static_cast<int>(disks.size());
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j) {
      const double gap = closest(disks[i], disks[j]) - disks[i].reach - disks[j].reach;
      if (std::abs(gap) > resolution) {
        EXPECT_EQ(found.count({i, j}) == 1, gap < 0) << i << " " << j;
      }
    }
}

TEST(PairSearch, finds_each_pair_that_comes_near_exactly_once) {
  for (const double speed : {0.0, 1.0, 20.0})
    expect_every_pair_once(random_disks(200, speed), 1e-5);
}

TEST(PairSearch, is_not_confused_by_disks_of_one_torus_cell_that_are_far_apart) {
  std::vector<SearchDisk> disks = random_disks(60, 1);
  for (std::size_t k = 0; k < disks.size(); k += 3) disks[k].x += 100 * (k % 2 ? 1 : -1);
  expect_every_pair_once(disks, 1e-5);
}

TEST(PairSearch, finds_small_disks_around_a_large_one) {
  std::vector<SearchDisk> disks = random_disks(80, 0);
  disks[17].reach = 0.3;
  expect_every_pair_once(disks, 1e-5);
}

}  // namespace
}  // namespace granary::dda
