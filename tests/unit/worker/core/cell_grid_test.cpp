#include "worker/core/cell_grid.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "worker/core/random.h"

namespace granary::core {
namespace {

std::vector<Vec3> random_points(std::size_t count, const Vec3& box) {
  std::vector<Vec3> points(count);
  for (std::size_t k = 0; k < count; ++k) {
    points[k] = {box.x * random_uniform(1, 0, k), box.y * random_uniform(1, 1, k),
                 box.z * random_uniform(1, 2, k)};
  }
  return points;
}

void expect_close_pairs_in_adjacent_cells(const std::vector<Vec3>& points, double reach) {
  CellGrid grid;
  grid.build(points, reach);
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = a + 1; b < points.size(); ++b) {
      if (norm(points[a] - points[b]) >= reach) continue;
      const auto ca = grid.coordinates(points[a]);
      const auto cb = grid.coordinates(points[b]);
      for (int axis = 0; axis < 3; ++axis) ASSERT_LE(std::abs(ca[axis] - cb[axis]), 1);
    }
  }
}

TEST(CellGrid, close_pairs_are_in_adjacent_cells) {
  expect_close_pairs_in_adjacent_cells(random_points(500, {1, 0.1, 0.05}), 0.03);
}

TEST(CellGrid, far_flung_points_do_not_ask_for_many_cells) {
  std::vector<Vec3> points = random_points(100, {1, 1, 1});
  points.push_back({1e6, -1e6, 1e6});
  CellGrid grid;
  grid.build(points, 0.01);
  EXPECT_LT(grid.cell_count(), 20'000U);
  expect_close_pairs_in_adjacent_cells(points, 0.05);
}

TEST(CellGrid, every_point_is_listed_once_and_ascending_in_its_cell) {
  const std::vector<Vec3> points = random_points(300, {1, 1, 1});
  CellGrid grid;
  grid.build(points, 0.2);
  std::vector<int> seen(points.size());
  for (std::size_t cell = 0; cell < grid.cell_count(); ++cell) {
    std::int64_t before = -1;
    for (const std::uint32_t point : grid.points_in(cell)) {
      EXPECT_GT(static_cast<std::int64_t>(point), before);
      before = point;
      ++seen[point];
    }
  }
  for (const int count : seen) EXPECT_EQ(count, 1);
}

TEST(CellGrid, one_point_and_no_point_are_fine) {
  CellGrid grid;
  grid.build(std::vector<Vec3>{{1, 2, 3}}, 0.1);
  EXPECT_EQ(grid.cell_count(), 1U);
  grid.build({}, 0.1);
  EXPECT_EQ(grid.order().size(), 0U);
}

}  // namespace
}  // namespace granary::core
