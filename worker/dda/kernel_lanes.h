// Eight contacts at a time: vectors of the compiler's generic 8 x double (the target decides how
// many registers that is), and records of disks transposed into them and back. Included by one
// source file per instruction set; everything has internal linkage, so that no function compiled
// for a large instruction set can leak into the others. always_inline: with a kernel for each
// combination of laws the compiler would rather call these, which costs a fifth of the speed.
#pragma once

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include <cmath>

#include "worker/dda/contact_list.h"
#include "worker/dda/kernels.h"

namespace granary::dda {
namespace {

typedef double Quad __attribute__((vector_size(32), aligned(32)));
typedef double Lanes __attribute__((vector_size(64), aligned(64)));
typedef long long Mask __attribute__((vector_size(64)));

static_assert(sizeof(DiskPose) == sizeof(Quad) && sizeof(DiskMotion) == sizeof(Quad));

[[gnu::always_inline]] inline Lanes load(const double* p) {
  return *reinterpret_cast<const Lanes*>(p);
}
[[gnu::always_inline]] inline void store(double* p, Lanes v) {
  *reinterpret_cast<Lanes*>(p) = v;
}
[[gnu::always_inline]] inline Lanes larger(Lanes a, Lanes b) {
  return a > b ? a : b;
}
[[gnu::always_inline]] inline Lanes smaller(Lanes a, Lanes b) {
  return a < b ? a : b;
}
[[gnu::always_inline]] inline Lanes all(double value) {
  return Lanes{} + value;
}
[[gnu::always_inline]] inline Lanes square_root(Lanes v) {
  Lanes root;
  for (std::size_t k = 0; k < kGroupSize; ++k) root[k] = std::sqrt(v[k]);
  return root;
}

struct Records {
  Lanes a, b, c, d;
};

// Eight records of four doubles, transposed. Record k and k + 4 share a register.
template <typename Record>
[[gnu::always_inline]] inline Records fetch(const Record* records, const std::int32_t* index) {
  const auto quad = [&](int k) { return *reinterpret_cast<const Quad*>(records + index[k]); };
  const auto join = [](Quad low, Quad high) {
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const Lanes r0 = join(quad(0), quad(4)), r1 = join(quad(1), quad(5));
  const Lanes r2 = join(quad(2), quad(6)), r3 = join(quad(3), quad(7));
  const Lanes ac01 = __builtin_shufflevector(r0, r1, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes bd01 = __builtin_shufflevector(r0, r1, 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes ac23 = __builtin_shufflevector(r2, r3, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes bd23 = __builtin_shufflevector(r2, r3, 1, 9, 3, 11, 5, 13, 7, 15);
  return {__builtin_shufflevector(ac01, ac23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(bd01, bd23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ac01, ac23, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(bd01, bd23, 2, 3, 10, 11, 6, 7, 14, 15)};
}

[[gnu::always_inline]] inline void put_back(DiskMotion* records, const std::int32_t* index,
                                            const Records& v) {
  const Lanes ab02 = __builtin_shufflevector(v.a, v.b, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes ab13 = __builtin_shufflevector(v.a, v.b, 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes cd02 = __builtin_shufflevector(v.c, v.d, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes cd13 = __builtin_shufflevector(v.c, v.d, 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes r0 = __builtin_shufflevector(ab02, cd02, 0, 1, 8, 9, 4, 5, 12, 13);
  const Lanes r1 = __builtin_shufflevector(ab13, cd13, 0, 1, 8, 9, 4, 5, 12, 13);
  const Lanes r2 = __builtin_shufflevector(ab02, cd02, 2, 3, 10, 11, 6, 7, 14, 15);
  const Lanes r3 = __builtin_shufflevector(ab13, cd13, 2, 3, 10, 11, 6, 7, 14, 15);
  const auto put = [&](int k, Lanes r) {
    *reinterpret_cast<Quad*>(records + index[k]) = __builtin_shufflevector(r, r, 0, 1, 2, 3);
    *reinterpret_cast<Quad*>(records + index[k + 4]) = __builtin_shufflevector(r, r, 4, 5, 6, 7);
  };
  put(0, r0), put(1, r1), put(2, r2), put(3, r3);
}

[[gnu::always_inline]] inline Lanes either(Mask where, Lanes yes, Lanes no) {
  return where ? yes : no;
}
// Does it hold in any lane?
[[gnu::always_inline]] inline bool any(const Mask& where) {
#if defined(__AVX512F__)
  const auto all_lanes = reinterpret_cast<const __m512i&>(where);
  return _mm512_test_epi64_mask(all_lanes, all_lanes) != 0;
#else
  long long joined = 0;
  for (std::size_t k = 0; k < kGroupSize; ++k) joined |= where[k];
  return joined != 0;
#endif
}
[[gnu::always_inline]] inline Lanes within(Lanes value, Lanes limit) {
  return larger(smaller(value, limit), -limit);
}

}  // namespace
}  // namespace granary::dda
