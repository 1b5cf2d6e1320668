// Where the disks start (PHYSICS section E 3): an ordered, slightly jittered array lowered into the
// bucket as far as its walls let it, to be dropped; or a compact order placed by hand inside it.
#pragma once

#include <cstdint>

#include "worker/dda/bucket.h"
#include "worker/dda/disks.h"

namespace granary::dda {

struct DiskKind {
  std::uint32_t count = 0;
  double diameter_min = 0;  // m, uniform between
  double diameter_max = 0;
  double mass_per_area = 0;  // kg/m2: density times axial depth
  std::uint64_t seed = 1;    // of diameters and jitter
};

inline constexpr std::uint32_t kStratumCount = 8;

Disks drop_array(const DiskKind& kind, const BucketGeometry& bucket);

// Hexagonal rows from the bottom up; places fewer than `count` when the bucket is full.
Disks compact_order(const DiskKind& kind, const BucketGeometry& bucket);

}  // namespace granary::dda
