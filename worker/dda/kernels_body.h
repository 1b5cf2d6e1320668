// Body of the kernels, included by one source file per instruction set; everything has internal
// linkage so that no function compiled for a large instruction set can leak into the others.
// Vectors are the compiler's generic 8 x double; the target decides how many registers that is.
// Scheme: PHYSICS section F, impulse form.

#include <cmath>

#include "worker/dda/contact_list.h"
#include "worker/dda/kernels.h"

namespace granary::dda {
namespace {

typedef double Quad __attribute__((vector_size(32), aligned(32)));
typedef double Lanes __attribute__((vector_size(64), aligned(64)));
typedef long long Mask __attribute__((vector_size(64)));

static_assert(sizeof(DiskPose) == sizeof(Quad) && sizeof(DiskMotion) == sizeof(Quad));

inline Lanes load(const double* p) {
  return *reinterpret_cast<const Lanes*>(p);
}
inline void store(double* p, Lanes v) {
  *reinterpret_cast<Lanes*>(p) = v;
}
inline Lanes larger(Lanes a, Lanes b) {
  return a > b ? a : b;
}
inline Lanes smaller(Lanes a, Lanes b) {
  return a < b ? a : b;
}
inline Lanes all(double value) {
  return Lanes{} + value;
}
inline Lanes square_root(Lanes v) {
  Lanes root;
  for (std::size_t k = 0; k < kGroupSize; ++k) root[k] = std::sqrt(v[k]);
  return root;
}

struct Records {
  Lanes a, b, c, d;
};

// Eight records of four doubles, transposed. Record k and k + 4 share a register.
template <typename Record>
inline Records fetch(const Record* records, const std::int32_t* index) {
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

inline void put_back(DiskMotion* records, const std::int32_t* index, const Records& v) {
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

// Adds impulse (n, t components) of a group: -P to the first disk, +P to the second. Record:
// a, b velocity, c surface speed, d inverse mass.
inline void add_impulse(Records& first, Records& second, Lanes nx, Lanes ny, Lanes impulse_n,
                        Lanes impulse_t, double spin_factor) {
  const Lanes px = impulse_n * nx - impulse_t * ny;
  const Lanes py = impulse_n * ny + impulse_t * nx;
  const Lanes torque = impulse_t * spin_factor;
  first.a -= first.d * px;
  first.b -= first.d * py;
  first.c -= first.d * torque;
  second.a += second.d * px;
  second.b += second.d * py;
  second.c -= second.d * torque;
}

void apply_impulses(const ContactArrays& contact, std::size_t count, double spin_factor,
                    DiskMotion* motion) {
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    Records first = fetch(motion, contact.first + g);
    Records second = fetch(motion, contact.second + g);
    add_impulse(first, second, load(contact.normal_x + g), load(contact.normal_y + g),
                load(contact.impulse_n + g), load(contact.impulse_t + g), spin_factor);
    put_back(motion, contact.first + g, first);
    put_back(motion, contact.second + g, second);
  }
}

void sweep(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
           DiskMotion* motion, SweepSums* sums) {
  const Lanes compliance = all(terms.compliance), friction = all(terms.friction);
  Lanes change = {}, total = {};
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    Records first = fetch(motion, contact.first + g);
    Records second = fetch(motion, contact.second + g);
    const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
    const Lanes ux = second.a - first.a, uy = second.b - first.b;
    const Lanes un = ux * nx + uy * ny;
    const Lanes ut = uy * nx - ux * ny - (first.c + second.c);
    const Lanes old_n = load(contact.impulse_n + g), old_t = load(contact.impulse_t + g);
    const Lanes residual_n = un + load(contact.bias_n + g) + compliance * old_n;
    const Lanes residual_t = ut + load(contact.bias_t + g) + compliance * old_t;
    const Lanes new_n = larger(old_n - residual_n * load(contact.weight_n + g), Lanes{});
    const Lanes limit = friction * new_n;
    const Lanes new_t =
        larger(smaller(old_t - residual_t * load(contact.weight_t + g), limit), -limit);
    const Lanes change_n = new_n - old_n, change_t = new_t - old_t;
    add_impulse(first, second, nx, ny, change_n, change_t, terms.spin_factor);
    store(contact.impulse_n + g, new_n);
    store(contact.impulse_t + g, new_t);
    put_back(motion, contact.first + g, first);
    put_back(motion, contact.second + g, second);
    change += change_n * change_n + change_t * change_t;
    total += new_n * new_n + new_t * new_t;
  }
  for (std::size_t k = 0; k < kGroupSize; ++k) {
    sums->change += change[k];
    sums->total += total[k];
  }
}

struct PairGeometry {
  Lanes nx, ny, gap_start, bias_n, weight_n, weight_t;
  Mask acts;
};

// Gap condition linearised about the positions that the velocities of the last step lead to, which
// is exact for a rigid rotation of the pair; about the present positions when the prediction would
// turn the normal by more than 60 deg (a pair that would pass through itself).
inline PairGeometry pair_geometry(const Records& p1, const Records& p2, const Records& v1,
                                  const Records& v2, Lanes force, const ContactTerms& terms) {
  const double dt = terms.time_step;
  const Lanes reach = p1.c + p2.c;
  const Lanes dx = p2.a - p1.a, dy = p2.b - p1.b;
  const Lanes ux = v2.a - v1.a, uy = v2.b - v1.b;
  const Lanes distance = square_root(dx * dx + dy * dy);
  const Lanes ex = dx + dt * ux, ey = dy + dt * uy;
  const Lanes end_distance = square_root(ex * ex + ey * ey);
  const Mask turned = (ex * dx + ey * dy) < 0.5 * distance * end_distance;
  const Lanes bx = turned ? dx : ex, by = turned ? dy : ey;
  const Lanes base = turned ? distance : end_distance;
  const Lanes nx = bx / base, ny = by / base;
  const Lanes un = ux * nx + uy * ny;
  const Lanes base_gap = base - reach;
  const Lanes gap_end = turned ? base_gap + dt * un : base_gap;
  const Lanes gap_start = distance - reach;
  const Mask bounces = (un < -terms.restitution_threshold) & (gap_end < 0.0);
  const Lanes position_bias = gap_end / dt - un;
  const Lanes bias = bounces & (all(terms.restitution) > 0.0)
                         ? smaller(position_bias, terms.restitution * un)
                         : position_bias;
  const Lanes inverse_mass = v1.d + v2.d;
  return {nx,
          ny,
          gap_start,
          bias,
          terms.relaxation / (inverse_mass + terms.compliance),
          terms.relaxation / ((1.0 + terms.spin_factor) * inverse_mass + terms.compliance),
          (smaller(gap_start, gap_end) < terms.margin_ratio * reach) | (force > 0.0)};
}

inline void pad_group(const ContactArrays& out, std::size_t& size, std::int32_t rest) {
  while (size % kGroupSize != 0) {
    out.first[size] = out.second[size] = rest;
    out.slot[size] = -1;
    out.normal_x[size] = 1;
    out.normal_y[size] = 0;
    out.bias_n[size] = 1;
    out.bias_t[size] = 0;
    out.weight_n[size] = out.weight_t[size] = 0;
    out.impulse_n[size] = out.impulse_t[size] = 0;
    out.gap_start[size] = 1;
    out.stored_t[size] = 0;
    ++size;
  }
}

std::size_t select_pairs(const CandidateArrays& candidates, const DiskPose* pose,
                         const DiskMotion* motion, std::int32_t rest, const ContactTerms& terms,
                         const ContactArrays& out, std::uint8_t* touched,
                         std::size_t* contact_count) {
  std::size_t size = 0, count = 0;
  for (std::size_t colour = 0; colour + 1 <= candidates.colour_count; ++colour) {
    for (std::size_t g = candidates.colour_start[colour]; g < candidates.colour_start[colour + 1];
         g += kGroupSize) {
      const std::int32_t* first = candidates.first + g;
      const std::int32_t* second = candidates.second + g;
      const Lanes force = load(candidates.normal_force + g);
      const PairGeometry pair =
          pair_geometry(fetch(pose, first), fetch(pose, second), fetch(motion, first),
                        fetch(motion, second), force, terms);
      for (std::size_t k = 0; k < kGroupSize; ++k) {
        if (!pair.acts[k] || first[k] == rest) continue;
        const double stored = candidates.tangential_force[g + k];
        out.first[size] = first[k];
        out.second[size] = second[k];
        out.slot[size] = static_cast<std::int32_t>(g + k);
        out.normal_x[size] = pair.nx[k];
        out.normal_y[size] = pair.ny[k];
        out.bias_n[size] = pair.bias_n[k];
        out.bias_t[size] = -terms.compliance * terms.time_step * stored;
        out.weight_n[size] = pair.weight_n[k];
        out.weight_t[size] = pair.weight_t[k];
        out.impulse_n[size] = terms.time_step * force[k];
        out.impulse_t[size] = terms.time_step * stored;
        out.gap_start[size] = pair.gap_start[k];
        out.stored_t[size] = stored;
        touched[first[k]] = touched[second[k]] = 1;
        ++size, ++count;
      }
    }
    pad_group(out, size, rest);
  }
  *contact_count = count;
  return size;
}

}  // namespace
}  // namespace granary::dda
