// Sixteen lanes in one AVX-512 register. Meaning of every function: lanes_portable.h.
#include <immintrin.h>

#include <utility>

#include "worker/dem/kernels.h"

namespace granary::dem {
namespace {

struct Lanes {
  __m512 v;
};
struct Mask {
  __mmask16 m;
};
struct Kinds {
  __m512i index;
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
  return {_mm512_set1_ps(value)};
}
inline Lanes load_any(const float* p) {
  return {_mm512_loadu_ps(p)};
}
inline void store(float* p, Lanes a) {
  _mm512_store_ps(p, a.v);
}
inline Lanes operator+(Lanes a, Lanes b) {
  return {_mm512_add_ps(a.v, b.v)};
}
inline Lanes operator-(Lanes a, Lanes b) {
  return {_mm512_sub_ps(a.v, b.v)};
}
inline Lanes operator*(Lanes a, Lanes b) {
  return {_mm512_mul_ps(a.v, b.v)};
}
inline Lanes operator/(Lanes a, Lanes b) {
  return {_mm512_div_ps(a.v, b.v)};
}
inline Lanes square_root(Lanes a) {
  return {_mm512_sqrt_ps(a.v)};
}
inline Lanes smaller(Lanes a, Lanes b) {
  return {_mm512_min_ps(a.v, b.v)};
}
inline Lanes larger(Lanes a, Lanes b) {
  return {_mm512_max_ps(a.v, b.v)};
}

inline Mask less(Lanes a, Lanes b) {
  return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)};
}
inline Mask operator&(Mask a, Mask b) {
  return {static_cast<__mmask16>(a.m & b.m)};
}
inline Mask mask_of(std::uint32_t bits) {
  return {static_cast<__mmask16>(bits)};
}
inline std::uint32_t bits(Mask m) {
  return m.m;
}
inline Lanes select(Mask m, Lanes a, Lanes b) {
  return {_mm512_mask_blend_ps(m.m, b.v, a.v)};
}
inline Lanes only(Mask m, Lanes a) {
  return {_mm512_maskz_mov_ps(m.m, a.v)};
}

template <typename Fold>
inline float fold_lanes(__m512 v, Fold fold) {
  const __m256 high = _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(v), 1));
  const __m256 v8 = fold(_mm512_castps512_ps256(v), high);
  const __m128 v4 =
      _mm256_castps256_ps128(fold(v8, _mm256_castps128_ps256(_mm256_extractf128_ps(v8, 1))));
  const __m256 w2 = fold(_mm256_castps128_ps256(v4), _mm256_castps128_ps256(_mm_movehl_ps(v4, v4)));
  const __m128 v2 = _mm256_castps256_ps128(w2);
  return _mm_cvtss_f32(
      _mm256_castps256_ps128(fold(w2, _mm256_castps128_ps256(_mm_movehdup_ps(v2)))));
}
inline float sum(Lanes a) {
  return fold_lanes(a.v, [](__m256 l, __m256 r) { return _mm256_add_ps(l, r); });
}
inline float largest(Lanes a) {
  return fold_lanes(a.v, [](__m256 l, __m256 r) { return _mm256_max_ps(l, r); });
}

inline Kinds kinds_at(const std::uint8_t* kind, std::size_t kinds) {
  if (kinds == 1) return {_mm512_setzero_si512(), 1};
  return {_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(kind))), kinds};
}
inline Kinds kinds_of(const std::uint8_t* kind, const std::uint32_t* slot, std::size_t kinds) {
  if (kinds == 1) return {_mm512_setzero_si512(), 1};
  alignas(16) std::uint8_t picked[kLanes];
#pragma GCC unroll 16
  for (std::size_t k = 0; k < kLanes; ++k) picked[k] = kind[slot[k]];
  return kinds_at(picked, kinds);
}
inline Kinds indices_at(const std::uint32_t* index, std::size_t kinds) {
  return {_mm512_loadu_si512(index), kinds};
}
inline Lanes lookup(const float* row, const Kinds& kinds) {
  if (kinds.kinds == 1) return all(row[0]);
  if (kinds.kinds <= kLanes) return {_mm512_permutexvar_ps(kinds.index, _mm512_load_ps(row))};
  return {_mm512_i32gather_ps(kinds.index, row, 4)};
}

// ------------------------------------------------------------------------- records to lanes and
// back

template <typename Record>
inline const Record* at(const Record* base, std::uint32_t offset) {
  return reinterpret_cast<const Record*>(reinterpret_cast<const char*>(base) +
                                         std::size_t{offset} *
                                             (sizeof(Record) / sizeof(GrainSurface)));
}
template <typename Record>
inline Record* at(Record* base, std::uint32_t offset) {
  return const_cast<Record*>(at(static_cast<const Record*>(base), offset));
}

// Quarter l of `quad[i]` holds row 4 l + i; gives columns 0..2 (and 3) in row order.
inline Columns transpose(const __m512 (&quad)[4], Lanes* fourth = nullptr) {
  const __m512 low01 = _mm512_unpacklo_ps(quad[0], quad[1]);
  const __m512 low23 = _mm512_unpacklo_ps(quad[2], quad[3]);
  const __m512 high01 = _mm512_unpackhi_ps(quad[0], quad[1]);
  const __m512 high23 = _mm512_unpackhi_ps(quad[2], quad[3]);
  const auto pair_low = [](__m512 a, __m512 b) {
    return _mm512_castpd_ps(_mm512_unpacklo_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
  };
  const auto pair_high = [](__m512 a, __m512 b) {
    return _mm512_castpd_ps(_mm512_unpackhi_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
  };
  if (fourth != nullptr) *fourth = {pair_high(high01, high23)};
  return {{pair_low(low01, low23)}, {pair_high(low01, low23)}, {pair_low(high01, high23)}};
}

inline __m512 join(__m256 low, __m256 high) {
  return _mm512_castpd_ps(
      _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_castps_pd(low)), _mm256_castps_pd(high), 1));
}

template <typename Difference>
inline Rows fetch_rows(Difference difference) {
  __m512 low[4], high[4];
  const auto row = [&](int k) { return _mm512_cvtpd_ps(difference(k)); };
#pragma GCC unroll 16
  for (int i = 0; i < 4; ++i) {
    const __m512 upper = join(row(i), row(4 + i));
    const __m512 lower = join(row(8 + i), row(12 + i));
    low[i] = _mm512_shuffle_f32x4(upper, lower, 0x88);
    high[i] = _mm512_shuffle_f32x4(upper, lower, 0xdd);
  }
  const Columns p = transpose(low), v = transpose(high);
  return {p.x, p.y, p.z, v.x, v.y, v.z};
}

inline Rows fetch_difference(const GrainMotion* base, const std::uint32_t* first,
                             const std::uint32_t* second) {
  return fetch_rows([&](int k) {
    return _mm512_sub_pd(_mm512_load_pd(at(base, first[k])), _mm512_load_pd(at(base, second[k])));
  });
}

inline Rows fetch_from(const GrainMotion* base, const std::uint32_t* first,
                       const GrainMotion* foot) {
  return fetch_rows([&](int k) {
    return _mm512_sub_pd(_mm512_load_pd(at(base, first[k])), _mm512_load_pd(foot + k));
  });
}

template <typename Value>
inline Columns fetch_columns(Value value) {
  __m512 quad[4];
#pragma GCC unroll 16
  for (int i = 0; i < 4; ++i) {
    const auto two = [&](int k) {
      return _mm512_cvtpd_ps(_mm512_insertf64x4(_mm512_castpd256_pd512(value(k)), value(k + 4), 1));
    };
    quad[i] = join(two(i), two(8 + i));
  }
  return transpose(quad);
}

inline Columns fetch_offset(const GrainMotion* base, const std::uint32_t* first,
                            const std::uint32_t* second) {
  return fetch_columns([&](int k) {
    return _mm256_sub_pd(_mm256_load_pd(at(base, first[k])->position),
                         _mm256_load_pd(at(base, second[k])->position));
  });
}

inline Columns fetch_surface(const GrainSurface* base, const std::uint32_t* first) {
  return fetch_columns([&](int k) { return _mm256_load_pd(at(base, first[k])->speed); });
}

inline Columns fetch_surface_sum(const GrainSurface* base, const std::uint32_t* first,
                                 const std::uint32_t* second) {
  return fetch_columns([&](int k) {
    return _mm256_add_pd(_mm256_load_pd(at(base, first[k])->speed),
                         _mm256_load_pd(at(base, second[k])->speed));
  });
}

// Rows of four columns: quarter l of quad[i] becomes row 4 l + i.
inline void rows_of(const Columns& c, __m512 fourth, __m512 (&quad)[4]) {
  const auto pd = [](__m512 a) { return _mm512_castps_pd(a); };
  const __m512 xy_low = _mm512_unpacklo_ps(c.x.v, c.y.v), z_low = _mm512_unpacklo_ps(c.z.v, fourth);
  const __m512 xy_high = _mm512_unpackhi_ps(c.x.v, c.y.v),
               z_high = _mm512_unpackhi_ps(c.z.v, fourth);
  quad[0] = _mm512_castpd_ps(_mm512_unpacklo_pd(pd(xy_low), pd(z_low)));
  quad[1] = _mm512_castpd_ps(_mm512_unpackhi_pd(pd(xy_low), pd(z_low)));
  quad[2] = _mm512_castpd_ps(_mm512_unpacklo_pd(pd(xy_high), pd(z_high)));
  quad[3] = _mm512_castpd_ps(_mm512_unpackhi_pd(pd(xy_high), pd(z_high)));
}

// Row k as eight floats, four of each table.
struct EightWide {
  __m512 pair[4][2];  // [i][h]: rows i + 8 h (low half) and i + 8 h + 4
  __m256 row(int k) const {
    const __m512 both = pair[k & 3][k >> 3];
    return (k & 4) == 0 ? _mm512_castps512_ps256(both)
                        : _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(both), 1));
  }
};

inline EightWide eight_wide(const Columns& low, __m512 low_fourth, const Columns& high) {
  const __m512i first_two =
      _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
  const __m512i last_two =
      _mm512_setr_epi32(8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
  __m512 t[4], f[4];
  rows_of(low, low_fourth, t);
  rows_of(high, _mm512_setzero_ps(), f);
  EightWide rows;
#pragma GCC unroll 16
  for (int i = 0; i < 4; ++i) {
    rows.pair[i][0] = _mm512_permutex2var_ps(t[i], first_two, f[i]);
    rows.pair[i][1] = _mm512_permutex2var_ps(t[i], last_two, f[i]);
  }
  return rows;
}

template <typename At>
inline Recollection fetch_memory(At at_row) {
  __m512 low[4], high[4];
#pragma GCC unroll 16
  for (int i = 0; i < 4; ++i) {
    const __m512 upper = join(at_row(i), at_row(4 + i));
    const __m512 lower = join(at_row(8 + i), at_row(12 + i));
    low[i] = _mm512_shuffle_f32x4(upper, lower, 0x88);
    high[i] = _mm512_shuffle_f32x4(upper, lower, 0xdd);
  }
  Recollection r;
  const Columns s = transpose(low, &r.touched), v = transpose(high);
  r.sx = s.x, r.sy = s.y, r.sz = s.z;
  r.vx = v.x, r.vy = v.y, r.vz = v.z;
  return r;
}
inline Recollection fetch_history(const History* base, const std::uint32_t* slot) {
  return fetch_memory([&](int k) { return _mm256_load_ps(base[slot[k]].spring); });
}
inline Recollection fetch_history(const History* base) {
  return fetch_memory([&](int k) { return _mm256_load_ps(base[k].spring); });
}

template <typename At>
inline void store_memory(const Recollection& r, At at_row) {
  const EightWide rows = eight_wide({r.sx, r.sy, r.sz}, r.touched.v, {r.vx, r.vy, r.vz});
#pragma GCC unroll 16
  for (int k = 0; k < static_cast<int>(kLanes); ++k) _mm256_store_ps(at_row(k), rows.row(k));
}
inline void store_history(History* base, const std::uint32_t* slot, const Recollection& r) {
  store_memory(r, [&](int k) { return base[slot[k]].spring; });
}
inline void store_history(History* base, const Recollection& r) {
  store_memory(r, [&](int k) { return base[k].spring; });
}

// load[first] += (turning_a, force), load[second] += (turning_b, -force), lane by lane.
template <bool kTurns, bool kTurningsDiffer>
inline void add_to_pairs(GrainLoad* base, const std::uint32_t* first, const std::uint32_t* second,
                         const Columns& turning_a, const Columns& turning_b, const Columns& force) {
  const __m512d reaction = _mm512_setr_pd(1, 1, 1, 1, -1, -1, -1, -1);
  const EightWide on_a = eight_wide(turning_a, _mm512_setzero_ps(), force);
  EightWide on_b;
  if constexpr (kTurningsDiffer) on_b = eight_wide(turning_b, _mm512_setzero_ps(), force);
#pragma GCC unroll 16
  for (int k = 0; k < static_cast<int>(kLanes); ++k) {
    const __m512d row_a = _mm512_cvtps_pd(on_a.row(k));
    const __m512d row_b = kTurningsDiffer ? _mm512_cvtps_pd(on_b.row(k)) : row_a;
    double* a = reinterpret_cast<double*>(at(base, first[k]));
    double* b = reinterpret_cast<double*>(at(base, second[k]));
    _mm512_store_pd(a, _mm512_add_pd(_mm512_load_pd(a), row_a));
    // The product with +-1 is exact: no contraction in disguise.
    _mm512_store_pd(b, _mm512_fmadd_pd(row_b, reaction, _mm512_load_pd(b)));
  }
}

template <bool kTurns>
inline void add_to_grains(GrainLoad* base, const std::uint32_t* first, const Columns& turning,
                          const Columns& force) {
  const EightWide rows = eight_wide(turning, _mm512_setzero_ps(), force);
#pragma GCC unroll 16
  for (int k = 0; k < static_cast<int>(kLanes); ++k) {
    double* a = reinterpret_cast<double*>(at(base, first[k]));
    _mm512_store_pd(a, _mm512_add_pd(_mm512_load_pd(a), _mm512_cvtps_pd(rows.row(k))));
  }
}

// --------------------------------------------------------------------------------- lists,
// integration

inline std::size_t write_slots(std::uint32_t* out, std::uint32_t start, std::uint32_t keep,
                               std::uint32_t flagged) {
  const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i slot = _mm512_add_epi32(lane, _mm512_set1_epi32(static_cast<int>(start)));
  const __m512i marked = _mm512_mask_or_epi32(slot, static_cast<__mmask16>(flagged), slot,
                                              _mm512_set1_epi32(static_cast<int>(kOverlaps)));
  // Compressed in a register, then stored whole: compress-stores are microcoded on Zen 4.
  _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(static_cast<__mmask16>(keep), marked));
  return static_cast<std::size_t>(__builtin_popcount(keep));
}

inline void write_active(const SlotArrays& slots, std::size_t at, std::uint32_t start,
                         std::uint32_t keep) {
  const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const auto put = [&](int column, __m512i value) {
    _mm512_storeu_si512(slots.active[column] + at,
                        _mm512_maskz_compress_epi32(static_cast<__mmask16>(keep), value));
  };
  put(0, _mm512_add_epi32(lane, _mm512_set1_epi32(static_cast<int>(start))));
  put(1, _mm512_loadu_si512(slots.first + start));
  put(2, _mm512_loadu_si512(slots.second + start));
}

inline std::size_t write_pairs(std::uint32_t* first, std::uint32_t* second, std::uint32_t a,
                               std::uint32_t b, std::uint32_t hits) {
  const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i index = _mm512_add_epi32(lane, _mm512_set1_epi32(static_cast<int>(b)));
  _mm512_storeu_si512(first, _mm512_set1_epi32(static_cast<int>(a * sizeof(GrainSurface))));
  _mm512_storeu_si512(second, _mm512_maskz_compress_epi32(static_cast<__mmask16>(hits),
                                                          _mm512_slli_epi32(index, 5)));
  return static_cast<std::size_t>(__builtin_popcount(hits));
}

struct Matrix {
  __m512d c0, c1, c2;
};
// Lower half from `low` (or zero), upper half from `high`; columns multiply (i, i+1, i+2)
// cyclically.
inline Matrix matrix(const double (*low)[3], const double (*high)[3]) {
  const auto column = [&](int j) {
    return _mm512_setr_pd(low[0][j], low[1][j], low[2][j], 0, high[0][j], high[1][j], high[2][j],
                          0);
  };
  return {column(0), column(1), column(2)};
}
inline __m512d multiply(const Matrix& m, __m512d v) {
  const __m512d next = _mm512_permutex_pd(v, 0xc9), last = _mm512_permutex_pd(v, 0xd2);
  return _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(m.c0, v), _mm512_mul_pd(m.c1, next)),
                       _mm512_mul_pd(m.c2, last));
}

template <bool kRotating, bool kTurns>
void integrate(const IntegrateTask& task) {
  const BodyCoefficients& body = *task.body;
  const double* c = body.constant;
  const double turn = body.turning_factor;
  const __m512d constant = _mm512_setr_pd(0, 0, 0, 0, c[0], c[1], c[2], 0);
  const __m512d factor = _mm512_setr_pd(turn, turn, turn, turn, 1, 1, 1, 1);
  const __m512d step = _mm512_set1_pd(body.time_step);
  [[maybe_unused]] const Matrix of_state = matrix(body.per_position, body.per_velocity);
  [[maybe_unused]] const Matrix of_load = matrix(body.per_turning, body.per_force);
  static constexpr double kNone[3][3] = {};
  [[maybe_unused]] const Matrix of_surface = matrix(body.per_surface, kNone);
  const auto move = [&](std::size_t k, __m512d load) {
    double* motion = task.block.motion[k].position;
    double* surface = task.block.surface[k].speed;
    const __m512d p = _mm512_load_pd(motion);
    const __m512d scales = _mm512_permutex_pd(p, 0xff);
    const __m512d inverse_mass = _mm512_shuffle_f64x2(scales, scales, 0x00);
    const __m512d free_step = _mm512_shuffle_f64x2(scales, scales, 0xee);
    __m512d rate = _mm512_mul_pd(_mm512_mul_pd(load, inverse_mass), factor);
    const __m256d s = _mm256_load_pd(surface);
    if constexpr (kRotating) {
      const __m512d state = multiply(of_state, p);
      const __m512d from_position = _mm512_shuffle_f64x2(state, state, 0x44);
      const __m512d own = multiply(of_surface, _mm512_zextpd256_pd512(s));
      rate = _mm512_add_pd(multiply(of_load, rate),
                           _mm512_mask_add_pd(own, 0xf0, from_position, state));
    }
    rate = _mm512_mul_pd(_mm512_add_pd(rate, constant), free_step);
    if constexpr (kTurns)
      _mm256_store_pd(surface, _mm256_mask_add_pd(s, 0x7, s, _mm512_castpd512_pd256(rate)));
    const __m512d kicked = _mm512_mask_add_pd(p, 0x70, p, rate);
    const __m512d drift = _mm512_mul_pd(_mm512_shuffle_f64x2(kicked, kicked, 0xee), step);
    _mm512_store_pd(motion, _mm512_mask_add_pd(kicked, 0x07, kicked, drift));
  };
  const __m512d zero = _mm512_setzero_pd();
  double* load = task.block.load[0].turning;
  const double* inflow = reinterpret_cast<const double*>(task.inflow);
  for (std::size_t k = 0; k < task.inflow_count; ++k) {
    move(k, _mm512_add_pd(_mm512_load_pd(load + 8 * k), _mm512_load_pd(inflow + 8 * k)));
    _mm512_store_pd(load + 8 * k, zero);
  }
  for (std::size_t k = task.inflow_count; k < task.block.count; ++k) {
    move(k, _mm512_load_pd(load + 8 * k));
    _mm512_store_pd(load + 8 * k, zero);
  }
}

}  // namespace
}  // namespace granary::dem
