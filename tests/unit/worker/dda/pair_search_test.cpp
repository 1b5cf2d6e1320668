#include "worker/dda/pair_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "worker/core/random.h"

namespace granary::dda {
namespace {

std::vector<SweptDisk> random_disks(int count, double speed) {
  std::vector<SweptDisk> disks;
  const auto random = [](std::uint64_t stream, int k) {
    return core::random_uniform(3, stream, k);
  };
  for (int k = 0; k < count; ++k)
    disks.push_back({random(1, k) - 0.5, random(2, k) - 0.5, speed * (random(3, k) - 0.5),
                     speed * (random(4, k) - 0.5), 0.01 + 0.01 * random(5, k), k});
  return disks;
}

// Closest approach sampled densely: an independent, slow answer.
double closest(const SweptDisk& a, const SweptDisk& b, double horizon) {
  double best = 1e9;
  for (int s = 0; s <= 2000; ++s) {
    const double t = horizon * s / 2000;
    best = std::min(best, std::hypot(b.x - a.x + t * (b.vx - a.vx), b.y - a.y + t * (b.vy - a.vy)));
  }
  return best;
}

TEST(PairSearch, finds_each_pair_that_comes_near_exactly_once) {
  for (const double speed : {0.0, 1.0, 20.0}) {
    const auto disks = random_disks(200, speed);
    const double horizon = 0.02;
    std::vector<DiskPair> pairs;
    PairSearch().find(disks, horizon, 0.045, pairs);
    std::set<std::pair<int, int>> found;
    for (const DiskPair& pair : pairs) {
      EXPECT_LT(pair.first, pair.second);
      EXPECT_TRUE(found.insert({pair.first, pair.second}).second);
    }
    for (int i = 0; i < 200; ++i)
      for (int j = i + 1; j < 200; ++j) {
        const double gap = closest(disks[i], disks[j], horizon) - disks[i].reach - disks[j].reach;
        if (std::abs(gap) > 1e-6) {
          EXPECT_EQ(found.count({i, j}) == 1, gap < 0) << i << " " << j;
        }
      }
  }
}

}  // namespace
}  // namespace granary::dda
