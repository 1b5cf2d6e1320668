// Sixteen lanes in two AVX2 registers. Meaning of every function: lanes_portable.h.
#include <immintrin.h>

#include <utility>

#include "worker/dem/kernels.h"

namespace granary::dem {
namespace {

struct Lanes {
  __m256 a, b;  // lanes 0..7, 8..15
};
struct Mask {
  __m256 a, b;
};
struct Kinds {
  __m256i a, b;
  std::size_t kinds;
};
struct Columns {
  Lanes x, y, z;
};
struct Rows {
  Lanes px, py, pz, vx, vy, vz;
};
struct Recollection {  // columns of History
  Lanes sx, sy, sz, touched, vx, vy, vz;
};

inline Lanes all(float value) {
  return {_mm256_set1_ps(value), _mm256_set1_ps(value)};
}
inline Lanes load_any(const float* p) {
  return {_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)};
}
inline void store(float* p, const Lanes& v) {
  _mm256_store_ps(p, v.a), _mm256_store_ps(p + 8, v.b);
}
inline Lanes operator+(const Lanes& l, const Lanes& r) {
  return {_mm256_add_ps(l.a, r.a), _mm256_add_ps(l.b, r.b)};
}
inline Lanes operator-(const Lanes& l, const Lanes& r) {
  return {_mm256_sub_ps(l.a, r.a), _mm256_sub_ps(l.b, r.b)};
}
inline Lanes operator*(const Lanes& l, const Lanes& r) {
  return {_mm256_mul_ps(l.a, r.a), _mm256_mul_ps(l.b, r.b)};
}
inline Lanes operator/(const Lanes& l, const Lanes& r) {
  return {_mm256_div_ps(l.a, r.a), _mm256_div_ps(l.b, r.b)};
}
inline Lanes square_root(const Lanes& v) {
  return {_mm256_sqrt_ps(v.a), _mm256_sqrt_ps(v.b)};
}
inline Lanes smaller(const Lanes& l, const Lanes& r) {
  return {_mm256_min_ps(l.a, r.a), _mm256_min_ps(l.b, r.b)};
}
inline Lanes larger(const Lanes& l, const Lanes& r) {
  return {_mm256_max_ps(l.a, r.a), _mm256_max_ps(l.b, r.b)};
}

inline Mask less(const Lanes& l, const Lanes& r) {
  return {_mm256_cmp_ps(l.a, r.a, _CMP_LT_OQ), _mm256_cmp_ps(l.b, r.b, _CMP_LT_OQ)};
}
inline Mask operator&(const Mask& l, const Mask& r) {
  return {_mm256_and_ps(l.a, r.a), _mm256_and_ps(l.b, r.b)};
}
inline Mask mask_of(std::uint32_t bits) {
  const auto half = [](std::uint32_t eight) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i found = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(eight)), bit);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(found, bit));
  };
  return {half(bits & 0xffU), half(bits >> 8)};
}
inline std::uint32_t bits(const Mask& m) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(m.a)) |
         static_cast<std::uint32_t>(_mm256_movemask_ps(m.b)) << 8;
}
inline Lanes select(const Mask& m, const Lanes& l, const Lanes& r) {
  return {_mm256_blendv_ps(r.a, l.a, m.a), _mm256_blendv_ps(r.b, l.b, m.b)};
}
inline Lanes only(const Mask& m, const Lanes& v) {
  return {_mm256_and_ps(m.a, v.a), _mm256_and_ps(m.b, v.b)};
}

template <typename Fold>
inline float fold_lanes(const Lanes& v, Fold fold) {
  const __m256 v8 = fold(v.a, v.b);
  const __m256 v4 = fold(v8, _mm256_permute2f128_ps(v8, v8, 1));
  const __m256 v2 = fold(v4, _mm256_permute_ps(v4, 0x0e));
  return _mm256_cvtss_f32(fold(v2, _mm256_permute_ps(v2, 0x01)));
}
inline float sum(const Lanes& v) {
  return fold_lanes(v, [](__m256 l, __m256 r) { return _mm256_add_ps(l, r); });
}
inline float largest(const Lanes& v) {
  return fold_lanes(v, [](__m256 l, __m256 r) { return _mm256_max_ps(l, r); });
}

inline Kinds kinds_at(const std::uint8_t* kind, std::size_t kinds) {
  if (kinds == 1) return {_mm256_setzero_si256(), _mm256_setzero_si256(), 1};
  const __m128i packed = _mm_loadu_si128(reinterpret_cast<const __m128i*>(kind));
  return {_mm256_cvtepu8_epi32(packed), _mm256_cvtepu8_epi32(_mm_srli_si128(packed, 8)), kinds};
}
inline Kinds kinds_of(const std::uint8_t* kind, const std::uint32_t* slot, std::size_t kinds) {
  if (kinds == 1) return {_mm256_setzero_si256(), _mm256_setzero_si256(), 1};
  alignas(16) std::uint8_t picked[kLanes];
#pragma GCC unroll 16
  for (std::size_t k = 0; k < kLanes; ++k) picked[k] = kind[slot[k]];
  return kinds_at(picked, kinds);
}
inline Kinds indices_at(const std::uint32_t* index, std::size_t kinds) {
  const auto* p = reinterpret_cast<const __m256i*>(index);
  return {_mm256_loadu_si256(p), _mm256_loadu_si256(p + 1), kinds};
}
inline Lanes lookup(const float* row, const Kinds& kinds) {
  if (kinds.kinds == 1) return all(row[0]);
  return {_mm256_i32gather_ps(row, kinds.a, 4), _mm256_i32gather_ps(row, kinds.b, 4)};
}

// ------------------------------------------------------------------------- records to lanes and
// back

template <typename Record>
inline const double* at(const Record* base, std::uint32_t offset) {
  return reinterpret_cast<const double*>(reinterpret_cast<const char*>(base) +
                                         std::size_t{offset} *
                                             (sizeof(Record) / sizeof(GrainSurface)));
}
template <typename Record>
inline double* at(Record* base, std::uint32_t offset) {
  return const_cast<double*>(at(static_cast<const Record*>(base), offset));
}

struct Eight {
  __m256 x, y, z, fourth;
};

// 128-bit half l of quad[i] holds row 4 l + i; gives the columns in row order.
inline Eight transpose(const __m256 (&quad)[4]) {
  const __m256 low01 = _mm256_unpacklo_ps(quad[0], quad[1]);
  const __m256 low23 = _mm256_unpacklo_ps(quad[2], quad[3]);
  const __m256 high01 = _mm256_unpackhi_ps(quad[0], quad[1]);
  const __m256 high23 = _mm256_unpackhi_ps(quad[2], quad[3]);
  const auto pd = [](__m256 v) { return _mm256_castps_pd(v); };
  return {_mm256_castpd_ps(_mm256_unpacklo_pd(pd(low01), pd(low23))),
          _mm256_castpd_ps(_mm256_unpackhi_pd(pd(low01), pd(low23))),
          _mm256_castpd_ps(_mm256_unpacklo_pd(pd(high01), pd(high23))),
          _mm256_castpd_ps(_mm256_unpackhi_pd(pd(high01), pd(high23)))};
}

// value(k): three doubles of row k, in float.
template <typename Value>
inline Columns fetch_columns(Value value) {
  Eight half[2];
#pragma GCC unroll 16
  for (int h = 0; h < 2; ++h) {
    __m256 quad[4];
#pragma GCC unroll 16
    for (int i = 0; i < 4; ++i) {
      quad[i] =
          _mm256_set_m128(_mm256_cvtpd_ps(value(8 * h + 4 + i)), _mm256_cvtpd_ps(value(8 * h + i)));
    }
    half[h] = transpose(quad);
  }
  return {{half[0].x, half[1].x}, {half[0].y, half[1].y}, {half[0].z, half[1].z}};
}

inline Rows join(const Columns& p, const Columns& v) {
  return {p.x, p.y, p.z, v.x, v.y, v.z};
}

inline Rows fetch_difference(const GrainMotion* base, const std::uint32_t* first,
                             const std::uint32_t* second) {
  const auto part = [&](int start) {
    return fetch_columns([=](int k) {
      return _mm256_sub_pd(_mm256_load_pd(at(base, first[k]) + start),
                           _mm256_load_pd(at(base, second[k]) + start));
    });
  };
  return join(part(0), part(4));
}

inline Rows fetch_from(const GrainMotion* base, const std::uint32_t* first,
                       const GrainMotion* foot) {
  const auto part = [&](int start) {
    return fetch_columns([=](int k) {
      return _mm256_sub_pd(_mm256_load_pd(at(base, first[k]) + start),
                           _mm256_load_pd(reinterpret_cast<const double*>(foot + k) + start));
    });
  };
  return join(part(0), part(4));
}

inline Columns fetch_offset(const GrainMotion* base, const std::uint32_t* first,
                            const std::uint32_t* second) {
  return fetch_columns([&](int k) {
    return _mm256_sub_pd(_mm256_load_pd(at(base, first[k])), _mm256_load_pd(at(base, second[k])));
  });
}

inline Columns fetch_surface(const GrainSurface* base, const std::uint32_t* first) {
  return fetch_columns([&](int k) { return _mm256_load_pd(at(base, first[k])); });
}

inline Columns fetch_surface_sum(const GrainSurface* base, const std::uint32_t* first,
                                 const std::uint32_t* second) {
  return fetch_columns([&](int k) {
    return _mm256_add_pd(_mm256_load_pd(at(base, first[k])), _mm256_load_pd(at(base, second[k])));
  });
}

// Rows of four columns: row k of the eight is half k / 4 of quad[k % 4].
struct EightRows {
  __m256 quad[4];
  __m128 floats(int k) const {
    const __m256 both = quad[k & 3];
    return k < 4 ? _mm256_castps256_ps128(both) : _mm256_extractf128_ps(both, 1);
  }
  __m256d row(int k) const { return _mm256_cvtps_pd(floats(k)); }
};
inline EightRows rows_of(__m256 x, __m256 y, __m256 z, __m256 fourth) {
  const auto pd = [](__m256 v) { return _mm256_castps_pd(v); };
  const __m256 xy_low = _mm256_unpacklo_ps(x, y), z_low = _mm256_unpacklo_ps(z, fourth);
  const __m256 xy_high = _mm256_unpackhi_ps(x, y), z_high = _mm256_unpackhi_ps(z, fourth);
  return {{_mm256_castpd_ps(_mm256_unpacklo_pd(pd(xy_low), pd(z_low))),
           _mm256_castpd_ps(_mm256_unpackhi_pd(pd(xy_low), pd(z_low))),
           _mm256_castpd_ps(_mm256_unpacklo_pd(pd(xy_high), pd(z_high))),
           _mm256_castpd_ps(_mm256_unpackhi_pd(pd(xy_high), pd(z_high)))}};
}
inline EightRows rows_of(const Columns& c, int half, const Lanes& fourth = all(0)) {
  return half == 0 ? rows_of(c.x.a, c.y.a, c.z.a, fourth.a)
                   : rows_of(c.x.b, c.y.b, c.z.b, fourth.b);
}

template <typename At>
inline Recollection fetch_memory(At at_row) {
  Eight s[2], v[2];
#pragma GCC unroll 16
  for (int h = 0; h < 2; ++h) {
    __m256 low[4], high[4];
#pragma GCC unroll 16
    for (int i = 0; i < 4; ++i) {
      const float* a = at_row(8 * h + i);
      const float* b = at_row(8 * h + 4 + i);
      low[i] = _mm256_set_m128(_mm_load_ps(b), _mm_load_ps(a));
      high[i] = _mm256_set_m128(_mm_load_ps(b + 4), _mm_load_ps(a + 4));
    }
    s[h] = transpose(low);
    v[h] = transpose(high);
  }
  return {{s[0].x, s[1].x}, {s[0].y, s[1].y}, {s[0].z, s[1].z}, {s[0].fourth, s[1].fourth},
          {v[0].x, v[1].x}, {v[0].y, v[1].y}, {v[0].z, v[1].z}};
}
inline Recollection fetch_history(const History* base, const std::uint32_t* slot) {
  return fetch_memory([&](int k) { return base[slot[k]].spring; });
}
inline Recollection fetch_history(const History* base) {
  return fetch_memory([&](int k) { return base[k].spring; });
}

template <typename At>
inline void store_memory(const Recollection& r, At at_row) {
#pragma GCC unroll 16
  for (int h = 0; h < 2; ++h) {
    const EightRows s = rows_of({r.sx, r.sy, r.sz}, h, r.touched);
    const EightRows v = rows_of({r.vx, r.vy, r.vz}, h);
#pragma GCC unroll 16
    for (int k = 0; k < 8; ++k) {
      _mm_store_ps(at_row(8 * h + k), s.floats(k));
      _mm_store_ps(at_row(8 * h + k) + 4, v.floats(k));
    }
  }
}
inline void store_history(History* base, const std::uint32_t* slot, const Recollection& r) {
  store_memory(r, [&](int k) { return base[slot[k]].spring; });
}
inline void store_history(History* base, const Recollection& r) {
  store_memory(r, [&](int k) { return base[k].spring; });
}

inline void add_to(double* sum, __m256d value) {
  _mm256_store_pd(sum, _mm256_add_pd(_mm256_load_pd(sum), value));
}

// load[first] += (turning_a, force), load[second] += (turning_b, -force), lane by lane.
template <bool kTurns, bool kTurningsDiffer>
inline void add_to_pairs(GrainLoad* base, const std::uint32_t* first, const std::uint32_t* second,
                         const Columns& turning_a, const Columns& turning_b, const Columns& force) {
#pragma GCC unroll 16
  for (int h = 0; h < 2; ++h) {
    const EightRows f = rows_of(force, h), ta = rows_of(turning_a, h);
    const EightRows tb = kTurningsDiffer ? rows_of(turning_b, h) : ta;
#pragma GCC unroll 16
    for (int k = 0; k < 8; ++k) {
      double* a = at(base, first[8 * h + k]);
      double* b = at(base, second[8 * h + k]);
      const __m256d push = f.row(k);
      if constexpr (kTurns) add_to(a, ta.row(k));
      add_to(a + 4, push);
      if constexpr (kTurns) add_to(b, tb.row(k));
      _mm256_store_pd(b + 4, _mm256_sub_pd(_mm256_load_pd(b + 4), push));
    }
  }
}

template <bool kTurns>
inline void add_to_grains(GrainLoad* base, const std::uint32_t* first, const Columns& turning,
                          const Columns& force) {
#pragma GCC unroll 16
  for (int h = 0; h < 2; ++h) {
    const EightRows f = rows_of(force, h), t = rows_of(turning, h);
#pragma GCC unroll 16
    for (int k = 0; k < 8; ++k) {
      double* a = at(base, first[8 * h + k]);
      if constexpr (kTurns) add_to(a, t.row(k));
      add_to(a + 4, f.row(k));
    }
  }
}

// --------------------------------------------------------------------------------- lists,
// integration

inline std::size_t write_slots(std::uint32_t* out, std::uint32_t start, std::uint32_t keep,
                               std::uint32_t flagged) {
  std::size_t count = 0;
  for (; keep != 0; keep &= keep - 1) {
    const auto lane = static_cast<std::uint32_t>(__builtin_ctz(keep));
    out[count++] = (start + lane) | ((flagged >> lane & 1U) << 31);
  }
  return count;
}

inline void write_active(const SlotArrays& slots, std::size_t at, std::uint32_t start,
                         std::uint32_t keep) {
  for (; keep != 0; keep &= keep - 1, ++at) {
    const std::uint32_t slot = start + static_cast<std::uint32_t>(__builtin_ctz(keep));
    slots.active[0][at] = slot;
    slots.active[1][at] = slots.first[slot];
    slots.active[2][at] = slots.second[slot];
  }
}

inline std::size_t write_pairs(std::uint32_t* first, std::uint32_t* second, std::uint32_t a,
                               std::uint32_t b, std::uint32_t hits) {
  std::size_t count = 0;
  for (; hits != 0; hits &= hits - 1) {
    first[count] = a * sizeof(GrainSurface);
    second[count++] = (b + static_cast<std::uint32_t>(__builtin_ctz(hits))) * sizeof(GrainSurface);
  }
  return count;
}

struct Matrix {
  __m256d c0, c1, c2;
};
inline Matrix matrix(const double (*m)[3]) {
  const auto column = [&](int j) { return _mm256_setr_pd(m[0][j], m[1][j], m[2][j], 0); };
  return {column(0), column(1), column(2)};
}
inline __m256d multiply(const Matrix& m, __m256d v) {
  const __m256d next = _mm256_permute4x64_pd(v, 0xc9), last = _mm256_permute4x64_pd(v, 0xd2);
  return _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(m.c0, v), _mm256_mul_pd(m.c1, next)),
                       _mm256_mul_pd(m.c2, last));
}

template <bool kRotating, bool kTurns>
void integrate(const IntegrateTask& task) {
  const BodyCoefficients& body = *task.body;
  const __m256d zero = _mm256_setzero_pd();
  const __m256d constant = _mm256_setr_pd(body.constant[0], body.constant[1], body.constant[2], 0);
  [[maybe_unused]] const __m256d factor = _mm256_set1_pd(body.turning_factor);
  const __m256d step = _mm256_set1_pd(body.time_step);
  [[maybe_unused]] const Matrix of_position = matrix(body.per_position);
  [[maybe_unused]] const Matrix of_velocity = matrix(body.per_velocity);
  [[maybe_unused]] const Matrix of_force = matrix(body.per_force);
  [[maybe_unused]] const Matrix of_turning = matrix(body.per_turning);
  [[maybe_unused]] const Matrix of_surface = matrix(body.per_surface);
  const auto move = [&](std::size_t k, __m256d turning, __m256d force) {
    GrainMotion& motion = task.block.motion[k];
    [[maybe_unused]] double* surface = task.block.surface[k].speed;
    const __m256d p = _mm256_load_pd(motion.position), v = _mm256_load_pd(motion.velocity);
    const __m256d inverse_mass = _mm256_broadcast_sd(&motion.inverse_mass);
    const __m256d free_step = _mm256_broadcast_sd(&motion.free_step);
    __m256d rate = _mm256_mul_pd(force, inverse_mass);
    if constexpr (kRotating) {
      rate = _mm256_add_pd(multiply(of_force, rate),
                           _mm256_add_pd(multiply(of_position, p), multiply(of_velocity, v)));
    }
    rate = _mm256_mul_pd(_mm256_add_pd(rate, constant), free_step);
    if constexpr (kTurns) {
      const __m256d s = _mm256_load_pd(surface);
      __m256d surface_rate = _mm256_mul_pd(_mm256_mul_pd(turning, inverse_mass), factor);
      if constexpr (kRotating)
        surface_rate = _mm256_add_pd(multiply(of_turning, surface_rate), multiply(of_surface, s));
      // The sum with zero makes a negative zero positive, as it does in a full register.
      surface_rate = _mm256_mul_pd(_mm256_add_pd(surface_rate, zero), free_step);
      _mm256_store_pd(surface, _mm256_blend_pd(_mm256_add_pd(s, surface_rate), s, 0x8));
    }
    const __m256d kicked = _mm256_blend_pd(_mm256_add_pd(v, rate), v, 0x8);
    const __m256d moved = _mm256_add_pd(p, _mm256_mul_pd(kicked, step));
    _mm256_store_pd(motion.velocity, kicked);
    _mm256_store_pd(motion.position, _mm256_blend_pd(moved, p, 0x8));
  };
  const auto clear = [&](GrainLoad& load) {
    _mm256_store_pd(load.turning, zero);
    _mm256_store_pd(load.force, zero);
  };
  for (std::size_t k = 0; k < task.inflow_count; ++k) {
    GrainLoad& own = task.block.load[k];
    const GrainLoad& in = task.inflow[k];
    move(k, _mm256_add_pd(_mm256_load_pd(own.turning), _mm256_load_pd(in.turning)),
         _mm256_add_pd(_mm256_load_pd(own.force), _mm256_load_pd(in.force)));
    clear(own);
  }
  for (std::size_t k = task.inflow_count; k < task.block.count; ++k) {
    GrainLoad& own = task.block.load[k];
    move(k, _mm256_load_pd(own.turning), _mm256_load_pd(own.force));
    clear(own);
  }
}

}  // namespace
}  // namespace granary::dem
