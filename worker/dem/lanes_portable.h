// Sixteen lanes in plain C++: the meaning of what lanes_avx2.h and lanes_avx512.h do with
// registers. Every function rounds once per operation, as IEEE 754 asks.
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/dem/kernels.h"

namespace granary::dem {
namespace {

typedef float Quad __attribute__((vector_size(16)));
typedef std::int32_t QuadMask __attribute__((vector_size(16)));
constexpr int kQuads = 4;

struct Lanes {
  Quad q[kQuads];
};
struct Mask {
  QuadMask q[kQuads];
};
struct Kinds {
  std::uint32_t index[kLanes];
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

template <typename Make>
inline Lanes by_quads(Make make) {
  return {{make(0), make(1), make(2), make(3)}};
}

inline Lanes all(float value) {
  return by_quads([&](int) { return Quad{value, value, value, value}; });
}
inline Lanes load_any(const float* p) {
  return by_quads([&](int k) {
    Quad q;
    __builtin_memcpy(&q, p + 4 * k, sizeof q);
    return q;
  });
}
inline void store(float* p, const Lanes& a) {
  __builtin_memcpy(p, &a, sizeof a);
}
inline Lanes operator+(const Lanes& a, const Lanes& b) {
  return by_quads([&](int k) { return a.q[k] + b.q[k]; });
}
inline Lanes operator-(const Lanes& a, const Lanes& b) {
  return by_quads([&](int k) { return a.q[k] - b.q[k]; });
}
inline Lanes operator*(const Lanes& a, const Lanes& b) {
  return by_quads([&](int k) { return a.q[k] * b.q[k]; });
}
inline Lanes operator/(const Lanes& a, const Lanes& b) {
  return by_quads([&](int k) { return a.q[k] / b.q[k]; });
}
inline Lanes square_root(const Lanes& a) {
  return by_quads([&](int k) {
    return Quad{std::sqrt(a.q[k][0]), std::sqrt(a.q[k][1]), std::sqrt(a.q[k][2]),
                std::sqrt(a.q[k][3])};
  });
}
// The second where either is not a number.
inline Lanes smaller(const Lanes& a, const Lanes& b) {
  return by_quads([&](int k) { return a.q[k] < b.q[k] ? a.q[k] : b.q[k]; });
}
inline Lanes larger(const Lanes& a, const Lanes& b) {
  return by_quads([&](int k) { return a.q[k] > b.q[k] ? a.q[k] : b.q[k]; });
}

template <typename Make>
inline Mask mask_by_quads(Make make) {
  return {{make(0), make(1), make(2), make(3)}};
}
inline Mask less(const Lanes& a, const Lanes& b) {
  return mask_by_quads([&](int k) { return a.q[k] < b.q[k]; });
}
inline Mask operator&(const Mask& a, const Mask& b) {
  return mask_by_quads([&](int k) { return a.q[k] & b.q[k]; });
}
inline Mask mask_of(std::uint32_t bits) {
  return mask_by_quads([&](int k) {
    const auto bit = [&](int j) { return (bits >> (4 * k + j) & 1U) != 0 ? -1 : 0; };
    return QuadMask{bit(0), bit(1), bit(2), bit(3)};
  });
}
inline std::uint32_t bits(const Mask& m) {
  std::uint32_t result = 0;
  for (std::uint32_t k = 0; k < kLanes; ++k) result |= (m.q[k / 4][k % 4] != 0 ? 1U : 0U) << k;
  return result;
}
inline Lanes select(const Mask& m, const Lanes& a, const Lanes& b) {
  return by_quads([&](int k) { return m.q[k] ? a.q[k] : b.q[k]; });
}
inline Lanes only(const Mask& m, const Lanes& a) {
  return select(m, a, all(0));
}

// Halves are folded onto each other: lane k with k + 8, then + 4, + 2, + 1.
template <typename Fold>
inline float fold_lanes(const Lanes& a, Fold fold) {
  float v[kLanes];
  store(v, a);
  for (std::size_t width = kLanes / 2; width > 0; width /= 2) {
    for (std::size_t k = 0; k < width; ++k) v[k] = fold(v[k], v[k + width]);
  }
  return v[0];
}
inline float sum(const Lanes& a) {
  return fold_lanes(a, [](float l, float r) { return l + r; });
}
inline float largest(const Lanes& a) {
  return fold_lanes(a, [](float l, float r) { return l > r ? l : r; });
}

inline Kinds kinds_at(const std::uint8_t* kind, std::size_t kinds) {
  Kinds result;
  result.kinds = kinds;
  if (kinds > 1) std::copy_n(kind, kLanes, result.index);
  return result;
}
inline Kinds kinds_of(const std::uint8_t* kind, const std::uint32_t* slot, std::size_t kinds) {
  Kinds result;
  result.kinds = kinds;
  if (kinds > 1) {
    for (std::size_t k = 0; k < kLanes; ++k) result.index[k] = kind[slot[k]];
  }
  return result;
}
inline Kinds indices_at(const std::uint32_t* index, std::size_t kinds) {
  Kinds result;
  result.kinds = kinds;
  std::copy_n(index, kLanes, result.index);
  return result;
}
inline Lanes lookup(const float* row, const Kinds& kinds) {
  if (kinds.kinds == 1) return all(row[0]);
  float v[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) v[k] = row[kinds.index[k]];
  return load_any(v);
}

// ------------------------------------------------------------------------- records to lanes and
// back

// Offsets count in bytes of GrainSurface.
template <typename Record>
inline Record& at(Record* base, std::uint32_t offset) {
  return base[offset / sizeof(GrainSurface)];
}

struct RowBuffer {
  float column[6][kLanes];
  void put(std::size_t k, const GrainMotion& a, const GrainMotion& b) {
    for (std::size_t j = 0; j < 3; ++j) {
      column[j][k] = static_cast<float>(a.position[j] - b.position[j]);
      column[3 + j][k] = static_cast<float>(a.velocity[j] - b.velocity[j]);
    }
  }
  Rows rows() const {
    return {load_any(column[0]), load_any(column[1]), load_any(column[2]),
            load_any(column[3]), load_any(column[4]), load_any(column[5])};
  }
};

inline Rows fetch_difference(const GrainMotion* base, const std::uint32_t* first,
                             const std::uint32_t* second) {
  RowBuffer buffer;
  for (std::size_t k = 0; k < kLanes; ++k) buffer.put(k, at(base, first[k]), at(base, second[k]));
  return buffer.rows();
}

inline Rows fetch_from(const GrainMotion* base, const std::uint32_t* first,
                       const GrainMotion* foot) {
  RowBuffer buffer;
  for (std::size_t k = 0; k < kLanes; ++k) buffer.put(k, at(base, first[k]), foot[k]);
  return buffer.rows();
}

template <typename Value>
inline Columns fetch_columns(Value value) {
  float column[3][kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) {
    for (std::size_t j = 0; j < 3; ++j) column[j][k] = static_cast<float>(value(k, j));
  }
  return {load_any(column[0]), load_any(column[1]), load_any(column[2])};
}

inline Columns fetch_offset(const GrainMotion* base, const std::uint32_t* first,
                            const std::uint32_t* second) {
  return fetch_columns([&](std::size_t k, std::size_t j) {
    return at(base, first[k]).position[j] - at(base, second[k]).position[j];
  });
}

inline Columns fetch_surface(const GrainSurface* base, const std::uint32_t* first) {
  return fetch_columns([&](std::size_t k, std::size_t j) { return at(base, first[k]).speed[j]; });
}

inline Columns fetch_surface_sum(const GrainSurface* base, const std::uint32_t* first,
                                 const std::uint32_t* second) {
  return fetch_columns([&](std::size_t k, std::size_t j) {
    return at(base, first[k]).speed[j] + at(base, second[k]).speed[j];
  });
}

template <typename At>
inline Recollection fetch_memory(At at_row) {
  float column[7][kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) {
    const History& h = at_row(k);
    for (std::size_t j = 0; j < 3; ++j) {
      column[j][k] = h.spring[j];
      column[4 + j][k] = h.velocity[j];
    }
    column[3][k] = h.touched;
  }
  return {load_any(column[0]), load_any(column[1]), load_any(column[2]), load_any(column[3]),
          load_any(column[4]), load_any(column[5]), load_any(column[6])};
}
inline Recollection fetch_history(const History* base, const std::uint32_t* slot) {
  return fetch_memory([&](std::size_t k) -> const History& { return base[slot[k]]; });
}
inline Recollection fetch_history(const History* base) {
  return fetch_memory([&](std::size_t k) -> const History& { return base[k]; });
}

template <typename At>
inline void store_memory(const Recollection& r, At at_row) {
  float column[7][kLanes];
  const Lanes* lanes[7] = {&r.sx, &r.sy, &r.sz, &r.touched, &r.vx, &r.vy, &r.vz};
  for (std::size_t j = 0; j < 7; ++j) store(column[j], *lanes[j]);
  for (std::size_t k = 0; k < kLanes; ++k) {
    at_row(k) = {{column[0][k], column[1][k], column[2][k]},
                 column[3][k],
                 {column[4][k], column[5][k], column[6][k]},
                 0};
  }
}
inline void store_history(History* base, const std::uint32_t* slot, const Recollection& r) {
  store_memory(r, [&](std::size_t k) -> History& { return base[slot[k]]; });
}
inline void store_history(History* base, const Recollection& r) {
  store_memory(r, [&](std::size_t k) -> History& { return base[k]; });
}

struct ColumnBuffer {
  float x[kLanes], y[kLanes], z[kLanes];
  explicit ColumnBuffer(const Columns& c) { store(x, c.x), store(y, c.y), store(z, c.z); }
};

inline void add(double (&sum)[3], const ColumnBuffer& c, std::size_t k, double sign) {
  sum[0] += sign * c.x[k];
  sum[1] += sign * c.y[k];
  sum[2] += sign * c.z[k];
}

// load[first] += (turning_a, force), load[second] += (turning_b, -force), lane by lane. Without
// kTurns grains do not turn: neither turnings nor speeds of surfaces are touched.
template <bool kTurns, bool kTurningsDiffer>
inline void add_to_pairs(GrainLoad* base, const std::uint32_t* first, const std::uint32_t* second,
                         const Columns& turning_a, const Columns& turning_b, const Columns& force) {
  const ColumnBuffer ta(turning_a), tb(kTurningsDiffer ? turning_b : turning_a), f(force);
  for (std::size_t k = 0; k < kLanes; ++k) {
    GrainLoad& a = at(base, first[k]);
    if constexpr (kTurns) add(a.turning, ta, k, 1);
    add(a.force, f, k, 1);
    GrainLoad& b = at(base, second[k]);
    if constexpr (kTurns) add(b.turning, tb, k, 1);
    add(b.force, f, k, -1);
  }
}

template <bool kTurns>
inline void add_to_grains(GrainLoad* base, const std::uint32_t* first, const Columns& turning,
                          const Columns& force) {
  const ColumnBuffer t(turning), f(force);
  for (std::size_t k = 0; k < kLanes; ++k) {
    GrainLoad& a = at(base, first[k]);
    if constexpr (kTurns) add(a.turning, t, k, 1);
    add(a.force, f, k, 1);
  }
}

// --------------------------------------------------------------------------------- lists,
// integration

// start + k for every bit k of keep, with kOverlaps set where `flagged` is.
inline std::size_t write_slots(std::uint32_t* out, std::uint32_t start, std::uint32_t keep,
                               std::uint32_t flagged) {
  std::size_t count = 0;
  for (; keep != 0; keep &= keep - 1) {
    const auto lane = static_cast<std::uint32_t>(__builtin_ctz(keep));
    out[count++] = (start + lane) | ((flagged >> lane & 1U) != 0 ? kOverlaps : 0U);
  }
  return count;
}

// Slots start + k for every bit k of keep, with their grains.
inline void write_active(const SlotArrays& slots, std::size_t at, std::uint32_t start,
                         std::uint32_t keep) {
  for (; keep != 0; keep &= keep - 1, ++at) {
    const std::uint32_t slot = start + static_cast<std::uint32_t>(__builtin_ctz(keep));
    slots.active[0][at] = slot;
    slots.active[1][at] = slots.first[slot];
    slots.active[2][at] = slots.second[slot];
  }
}

// Pairs (a, b + k) for every bit k of hits, in bytes of GrainSurface.
inline std::size_t write_pairs(std::uint32_t* first, std::uint32_t* second, std::uint32_t a,
                               std::uint32_t b, std::uint32_t hits) {
  std::size_t count = 0;
  for (; hits != 0; hits &= hits - 1) {
    first[count] = a * sizeof(GrainSurface);
    second[count++] = (b + static_cast<std::uint32_t>(__builtin_ctz(hits))) * sizeof(GrainSurface);
  }
  return count;
}

// Component i of a matrix given by its cyclic rows times v.
inline double component(const double (*m)[3], int i, const double* v) {
  return m[i][0] * v[i] + m[i][1] * v[(i + 1) % 3] + m[i][2] * v[(i + 2) % 3];
}

template <bool kRotating>
inline void turn_on(const BodyCoefficients& body, const GrainMotion& motion, GrainSurface& surface,
                    const double (&turning)[3]) {
  double turn[3], speed[3];
  for (int i = 0; i < 3; ++i) turn[i] = turning[i] * motion.inverse_mass * body.turning_factor;
  for (int i = 0; i < 3; ++i) {
    double rate = turn[i];
    if constexpr (kRotating)
      rate = component(body.per_turning, i, turn) + component(body.per_surface, i, surface.speed);
    // The sum with zero is no joke: it makes a negative zero positive, as it does in a full
    // register.
    speed[i] = surface.speed[i] + (rate + 0.0) * motion.free_step;
  }
  for (int i = 0; i < 3; ++i) surface.speed[i] = speed[i];
}

template <bool kRotating, bool kTurns>
inline void move(const BodyCoefficients& body, GrainMotion& motion, GrainSurface& surface,
                 const double (&turning)[3], const double (&force)[3]) {
  if constexpr (kTurns) turn_on<kRotating>(body, motion, surface, turning);
  double push[3], velocity[3];
  for (int i = 0; i < 3; ++i) push[i] = force[i] * motion.inverse_mass * 1.0;
  for (int i = 0; i < 3; ++i) {
    double rate = push[i];
    if constexpr (kRotating)
      rate =
          component(body.per_force, i, push) + (component(body.per_position, i, motion.position) +
                                                component(body.per_velocity, i, motion.velocity));
    velocity[i] = motion.velocity[i] + (rate + body.constant[i]) * motion.free_step;
  }
  for (int i = 0; i < 3; ++i) {
    motion.velocity[i] = velocity[i];
    motion.position[i] += velocity[i] * body.time_step;
  }
}

template <bool kRotating, bool kTurns>
void integrate(const IntegrateTask& task) {
  for (std::size_t k = 0; k < task.block.count; ++k) {
    GrainLoad& own = task.block.load[k];
    GrainLoad total = own;
    if (k < task.inflow_count) {
      for (int i = 0; i < 3; ++i) {
        if constexpr (kTurns) total.turning[i] += task.inflow[k].turning[i];
        total.force[i] += task.inflow[k].force[i];
      }
    }
    move<kRotating, kTurns>(*task.body, task.block.motion[k], task.block.surface[k], total.turning,
                            total.force);
    own = {};
  }
}

}  // namespace
}  // namespace granary::dem
