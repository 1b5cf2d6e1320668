// Which disks come closer than their reaches in the near future, if they keep their velocities.
// Disks are sorted into square cells by where they will be half-way. Most have about the same span
// and look into their own cell and half of the eight around it; the few that need to look further
// (large, or fast against their neighbours) search all cells within their span. The cell grid is a
// torus, so it costs no memory for the empty space between flying disks; what falls on the same
// cell from another turn of the torus is told apart by its distance.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace granary::dda {

struct SearchDisk {
  double x = 0, y = 0;  // half-way through the horizon
  double vx = 0, vy = 0;
  double reach = 0;  // pairs closer than the sum of theirs are wanted [m]
  double sweep = 0;  // half of what it may move against a neighbour by either end [m]
  std::int32_t index = 0;
};

struct DiskPair {
  std::int32_t first = 0;  // < second
  std::int32_t second = 0;
};

class PairSearch {
 public:
  // Pairs that come closer than the sum of their reaches, each once, in an order that depends on
  // nothing but the input: along rows of cells, bottom up.
  void find(std::span<const SearchDisk> disks, double horizon, std::vector<DiskPair>& pairs);

 private:
  struct Sorted {
    double x, y, span;  // span = reach + sweep
    double usual_span;  // the same, but for wide ones, which usual ones leave to them
  };
  struct Path {
    double x, y, vx, vy, reach;
    std::int32_t index;
  };
  static bool comes_near(const Path& a, const Path& b, double half_horizon);
  void choose_cells(std::span<const SearchDisk> disks);
  void sort_into_cells(std::span<const SearchDisk> disks);
  void look_around(std::size_t one);
  void look_far(std::size_t one);
  template <bool kIsWide>
  void look_into(std::size_t one, std::size_t begin, std::size_t end);
  std::uint32_t column_of(double x) const;
  std::uint32_t row_of(double y) const;

  double base_span_ = 0, inverse_cell_ = 0;
  std::uint32_t columns_ = 1;  // of the torus, as many rows; a power of two
  std::vector<double> spans_;
  std::vector<std::uint32_t> cell_of_, start_, sorted_cell_;
  std::vector<Sorted> sorted_;
  std::vector<Path> path_;      // in the same order
  std::vector<DiskPair> near_;  // places in sorted_
  std::size_t near_count_ = 0;
};

}  // namespace granary::dda
