// Which disks come within reach of each other in the near future. Each disk sweeps a box over the
// horizon; boxes are hashed into cells; pairs whose boxes meet are kept if straight relative motion
// brings them within the sum of their reaches (radius + pad). A fast cloud of flying disks
// therefore costs no more than a packed bed: only the relative motion counts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace granary::dda {

struct SweptDisk {
  double x = 0, y = 0;
  double vx = 0, vy = 0;  // in the frame in which the bed is slow
  double reach = 0;       // radius + pad [m]
  std::int32_t index = 0;
};

struct DiskPair {
  std::int32_t first = 0;  // < second
  std::int32_t second = 0;
};

class PairSearch {
 public:
  // Pairs in an order that depends on nothing but the input. Precondition: cell > 0.
  void find(std::span<const SweptDisk> disks, double horizon, double cell,
            std::vector<DiskPair>& pairs);

 private:
  struct Box {
    double x_min, y_min, x_max, y_max;
  };
  struct Entry {
    std::int32_t cell_x, cell_y, disk;
  };
  void sweep_boxes(std::span<const SweptDisk> disks, double horizon);
  void hash_boxes(double cell);
  void pair_bucket(std::span<const SweptDisk> disks, std::size_t begin, std::size_t end,
                   double horizon, double cell, std::vector<DiskPair>& pairs) const;

  std::vector<Box> boxes_;
  std::vector<Entry> unsorted_, entries_;
  std::vector<std::uint32_t> hash_, bucket_start_;
};

}  // namespace granary::dda
