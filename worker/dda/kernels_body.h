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

// ---- small steps

inline Lanes either(Mask where, Lanes yes, Lanes no) {
  return where ? yes : no;
}

// Relative displacement of the bodies since the start of the step, in the contact's axes.
struct Slide {
  Lanes tangential;  // m, between the surfaces
  Lanes gap;         // m, now
};

template <bool kWall>
inline Slide slide_of(const ContactArrays& contact, std::size_t g, Lanes nx, Lanes ny,
                      double elapsed, const DiskShift* shift) {
  const Records first = fetch(shift, contact.first + g);
  Lanes dx = -first.a, dy = -first.b, rolled = first.c;
  if constexpr (!kWall) {
    const Records second = fetch(shift, contact.second + g);
    dx += second.a, dy += second.b, rolled += second.c;
  }
  Lanes normal = dx * nx + dy * ny, across = dy * nx - dx * ny;
  if constexpr (kWall) {
    normal += load(contact.drift_n + g) * elapsed;
    across += load(contact.drift_t + g) * elapsed;
    return {across - rolled, load(contact.gap_linear + g) + normal};
  }
  const Lanes side = load(contact.offset_t + g) + across;
  return {across - rolled,
          load(contact.gap_linear + g) + normal + load(contact.curvature + g) * side * side};
}

struct LaneSums {
  Lanes change = {}, total = {}, integrator = {}, damping = {}, wall_work = {};
  Lanes tangential_work = {}, stick_work = {}, dashpot_work = {}, friction = {};

  void add_to(SmallStepSums& sums) const {
    for (std::size_t k = 0; k < kGroupSize; ++k) {
      sums.change += change[k];
      sums.total += total[k];
      sums.integrator += integrator[k];
      sums.damping += damping[k];
      sums.wall_work += wall_work[k];
      sums.tangential_work += tangential_work[k];
      sums.stick_work += stick_work[k];
      sums.dashpot_work += dashpot_work[k];
      sums.friction += friction[k];
    }
  }
};

// Books a finished small step: normal spring from overlap o0 to o1 under impulse P. The dashpot
// took c (o1 - o0)^2 / h, and P / h over the distance before the gap closed; a contact that lets
// go, all that was left in its spring. What the impulse did besides, because the sweeps ended
// before the law was met, is the integrator's. The tangential impulse of a sticking contact is that
// of the spring and of the dashpot; the spring's part is returned for the next small step.
template <bool kWall>
inline Lanes book_small_step(const ContactArrays& contact, std::size_t g, const ContactTerms& terms,
                             const Slide& slide, Lanes impulse_n, Lanes impulse_t, LaneSums& sums) {
  const Lanes gap = slide.gap;
  const double per_step = 1 / terms.small_step;
  const Lanes gap_before = load(contact.gap_now + g);
  const Lanes overlap = larger(-gap, Lanes{}), overlap_before = larger(-gap_before, Lanes{});
  const Lanes stretch = overlap - overlap_before;
  const Lanes by_law = (terms.damping_n * per_step) * (stretch * stretch) +
                       impulse_n * larger(gap_before, Lanes{}) * per_step;
  const Lanes by_work =
      impulse_n * (gap_before - gap) * per_step - terms.stiffness * overlap * stretch;
  const Lanes damping = either(impulse_n > 0.0, by_law, by_work);
  sums.damping += damping;
  sums.integrator += (by_work - damping) + (0.5 * terms.stiffness) * (stretch * stretch);
  const Lanes moved = slide.tangential - load(contact.slide_t + g);
  const Lanes limit = terms.friction * impulse_n;
  const Mask sticks = (impulse_t < limit) & (impulse_t > -limit);
  const Lanes spring = larger(smaller(impulse_t + terms.damping_t * moved, limit), -limit);
  const Lanes stick = either(sticks, spring, impulse_t);
  sums.tangential_work += impulse_t * moved;
  sums.dashpot_work += (stick - impulse_t) * moved;
  sums.stick_work += stick * (stick - load(contact.stick_t + g));
  if constexpr (kWall)
    sums.wall_work += impulse_n * load(contact.drift_n + g) + impulse_t * load(contact.drift_t + g);
  return stick;
}

// Collisions as jumps of the velocities: a contact that closes in this small step for the first
// time gets the rigid impulse that leaves it with its rebound speed, and the friction impulse that
// stops its sliding within Coulomb's limit. The velocities at the start of the small step jump too,
// so that the jump is neither taken for an acceleration nor for a work along the way.
template <bool kWall>
inline void rebound(const ContactArrays& contact, std::size_t g, const ContactTerms& terms,
                    Lanes gap, Lanes nx, Lanes ny, Records& first, Records& second,
                    DiskMotion* before, LaneSums& sums) {
  const Lanes wanted = load(contact.rebound + g);
  const Lanes drift_n = kWall ? load(contact.drift_n + g) : Lanes{};
  const Lanes drift_t = kWall ? load(contact.drift_t + g) : Lanes{};
  const auto normal_speed = [&](const Records& a, const Records& b) {
    return (b.a - a.a) * nx + (b.b - a.b) * ny + drift_n;
  };
  const auto surface_speed = [&](const Records& a, const Records& b) {
    return (b.b - a.b) * nx - (b.a - a.a) * ny - (a.c + b.c) + drift_t;
  };
  const Lanes un = normal_speed(first, second), ut = surface_speed(first, second);
  const Mask collides = (wanted > kNoRebound) & (gap + un * terms.small_step < 0.0);
  const Lanes mobility_n = first.d + second.d;
  const Lanes mobility_t = (1.0 + terms.spin_factor) * mobility_n;
  const Lanes impulse_n = either(collides, (wanted - un) / mobility_n, Lanes{});
  const Lanes limit = terms.friction * impulse_n;
  const Lanes impulse_t =
      either(collides, larger(smaller(-ut / mobility_t, limit), -limit), Lanes{});
  add_impulse(first, second, nx, ny, impulse_n, impulse_t, terms.spin_factor);

  Records first_before = fetch(before, contact.first + g);
  Records second_before = kWall ? Records{} : fetch(before, contact.second + g);
  sums.damping -= impulse_n * normal_speed(first_before, second_before) +
                  0.5 * impulse_n * impulse_n * mobility_n;
  sums.friction -= impulse_t * surface_speed(first_before, second_before) +
                   0.5 * impulse_t * impulse_t * mobility_t;
  if constexpr (kWall) sums.wall_work += impulse_n * drift_n + impulse_t * drift_t;
  add_impulse(first_before, second_before, nx, ny, impulse_n, impulse_t, terms.spin_factor);
  put_back(before, contact.first + g, first_before);
  if constexpr (!kWall) put_back(before, contact.second + g, second_before);
  store(contact.rebound + g, either(collides, all(kNoRebound), wanted));
}

template <bool kWall, bool kFirst>
void small_sweep(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                 const SmallStep& small, const DiskShift* shift, DiskMotion* motion,
                 DiskMotion* before, LaneSums& sums) {
  const double per_step = 1 / terms.small_step;
  const double recovery = terms.compliance_n / terms.compliance;
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
    const Lanes old_n = load(contact.impulse_n + g), old_t = load(contact.impulse_t + g);
    Lanes stick = old_t, gap;
    if constexpr (kFirst) {
      const Slide slide = slide_of<kWall>(contact, g, nx, ny, small.elapsed, shift);
      gap = slide.gap;
      if (small.books) stick = book_small_step<kWall>(contact, g, terms, slide, old_n, old_t, sums);
      store(contact.gap_now + g, gap);
      store(contact.slide_t + g, slide.tangential);
      store(contact.stick_t + g, stick);
    } else {
      gap = load(contact.gap_now + g);
      stick = load(contact.stick_t + g);
    }
    Records first = fetch(motion, contact.first + g);
    Records second = kWall ? Records{} : fetch(motion, contact.second + g);
    if (contact.group_rebounds[g / kGroupSize])
      rebound<kWall>(contact, g, terms, gap, nx, ny, first, second, before, sums);
    const Lanes ux = second.a - first.a, uy = second.b - first.b;
    Lanes un = ux * nx + uy * ny, ut = uy * nx - ux * ny - (first.c + second.c);
    if constexpr (kWall) un += load(contact.drift_n + g), ut += load(contact.drift_t + g);
    const Lanes weight_n = load(contact.weight_n + g);
    const Lanes bias = gap * either(gap > 0.0, all(per_step), all(per_step * recovery));
    const Lanes new_n =
        larger(old_n - (un + bias + terms.compliance_n * old_n) * weight_n, Lanes{});
    const Lanes limit = terms.friction * new_n;
    const Lanes trial_t =
        old_t - (ut + terms.compliance_t * (old_t - stick)) * load(contact.weight_t + g);
    const Lanes new_t = larger(smaller(trial_t, limit), -limit);
    const Lanes change_n = new_n - old_n, change_t = new_t - old_t;
    add_impulse(first, second, nx, ny, change_n, change_t, terms.spin_factor);
    store(contact.impulse_n + g, new_n);
    store(contact.impulse_t + g, new_t);
    put_back(motion, contact.first + g, first);
    if constexpr (!kWall) put_back(motion, contact.second + g, second);
    sums.change += change_n * change_n + change_t * change_t;
    sums.total += new_n * new_n + new_t * new_t;
  }
}

template <bool kWall>
void small_sweep_any(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                     const SmallStep& small, const DiskShift* shift, DiskMotion* motion,
                     DiskMotion* before, SmallStepSums* sums) {
  LaneSums lanes;
  if (small.first_sweep)
    small_sweep<kWall, true>(contact, count, terms, small, shift, motion, before, lanes);
  else
    small_sweep<kWall, false>(contact, count, terms, small, shift, motion, before, lanes);
  lanes.add_to(*sums);
}

template <bool kWall>
void close_contacts(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                    const SmallStep& small, const DiskShift* shift, SmallStepSums* sums,
                    ContactSums* contact_sums) {
  LaneSums lanes;
  Lanes overlap2 = {}, overlap2_start = {}, stored2 = {}, stick2 = {}, worst = {};
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
    const Slide slide = slide_of<kWall>(contact, g, nx, ny, small.elapsed, shift);
    const Lanes impulse_n = load(contact.impulse_n + g), impulse_t = load(contact.impulse_t + g);
    const Lanes stick =
        book_small_step<kWall>(contact, g, terms, slide, impulse_n, impulse_t, lanes);
    store(contact.impulse_t + g, stick);
    const Lanes overlap = larger(-slide.gap, Lanes{}), stored = load(contact.stored_t + g);
    const Lanes overlap_start = larger(-load(contact.gap_start + g), Lanes{});
    overlap2 += overlap * overlap;
    overlap2_start += overlap_start * overlap_start;
    stored2 += stored * stored;
    stick2 += stick * stick;
    worst = larger(worst, overlap_start);
  }
  lanes.add_to(*sums);
  for (std::size_t k = 0; k < kGroupSize; ++k) {
    contact_sums->overlap2 += overlap2[k];
    contact_sums->overlap2_start += overlap2_start[k];
    contact_sums->stored2 += stored2[k];
    contact_sums->stick2 += stick2[k];
    if (worst[k] > contact_sums->worst_overlap) contact_sums->worst_overlap = worst[k];
  }
}

double advance_disks(const std::uint32_t* index, std::size_t count, double small_step,
                     const double* mass, DiskMotion* motion, DiskMotion* before, DiskShift* shift) {
  Quad sum = {};
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t i = index[k];
    Quad& v = *reinterpret_cast<Quad*>(motion + i);
    Quad& old = *reinterpret_cast<Quad*>(before + i);
    Quad& moved = *reinterpret_cast<Quad*>(shift + i);
    const Quad end = v, gain = end - old;
    moved += small_step * end;
    sum += mass[i] * (gain * gain);
    old = end;
    v = end + gain;
  }
  return 0.5 * (sum[0] + sum[1] + 0.5 * sum[2]);
}

// ---- narrow phase

struct PairGeometry {
  Lanes nx, ny, gap_start, gap_linear, offset_t, curvature, bias_n, weight_n, weight_t, rebound;
  Mask bounces;
};

// The normal is taken where the velocities of the last step lead by `normal_time`; at the present
// positions when that would turn it by more than 60 deg (a pair that would pass through itself).
inline PairGeometry pair_geometry(const Records& p1, const Records& p2, const Records& v1,
                                  const Records& v2, Lanes force, const ContactTerms& terms) {
  const Lanes reach = p1.c + p2.c;
  const Lanes dx = p2.a - p1.a, dy = p2.b - p1.b;
  const Lanes ux = v2.a - v1.a, uy = v2.b - v1.b;
  const Lanes distance = square_root(dx * dx + dy * dy);
  const Lanes ex = dx + terms.normal_time * ux, ey = dy + terms.normal_time * uy;
  const Lanes distance_then = square_root(ex * ex + ey * ey);
  const Mask turned = (ex * dx + ey * dy) < 0.5 * distance * distance_then;
  const Lanes bx = either(turned, dx, ex), by = either(turned, dy, ey);
  const Lanes base = either(turned, distance, distance_then);
  const Lanes nx = bx / base, ny = by / base;
  const Lanes un = ux * nx + uy * ny;
  const Lanes gap_linear = dx * nx + dy * ny - reach;
  const Lanes inverse_mass = v1.d + v2.d;
  const Mask bounces =
      (un < -terms.restitution_threshold) & (gap_linear + un * terms.time_step < 0.0);
  const Lanes bias = gap_linear / terms.time_step;
  const bool elastic = terms.restitution > 0;
  return {nx,
          ny,
          distance - reach,
          gap_linear,
          dy * nx - dx * ny,
          0.5 / base,
          elastic ? either(bounces, smaller(bias, terms.restitution * un), bias) : bias,
          terms.relaxation / (inverse_mass + terms.compliance_n),
          terms.relaxation / ((1.0 + terms.spin_factor) * inverse_mass + terms.compliance_t),
          either(bounces & (force == 0.0), -terms.restitution * un, all(kNoRebound)),
          bounces & (force == 0.0)};
}

// Slots of the candidates of [begin, end) that can act: near at the end of the step, or in force.
inline std::size_t pick(const CandidateArrays& candidates, std::size_t begin, std::size_t end,
                        const DiskPose* ahead, std::int32_t rest, std::int32_t* picked) {
  std::size_t count = 0;
  for (std::size_t g = begin; g < end; g += kGroupSize) {
    const Records a = fetch(ahead, candidates.first + g), b = fetch(ahead, candidates.second + g);
    const Lanes dx = b.a - a.a, dy = b.b - a.b, reach = a.c + b.c;
    const Mask acts =
        (dx * dx + dy * dy < reach * reach) | (load(candidates.normal_force + g) > 0.0);
    for (std::size_t k = 0; k < kGroupSize; ++k) {
      picked[count] = static_cast<std::int32_t>(g + k);
      count += static_cast<std::size_t>((acts[k] != 0) & (candidates.first[g + k] != rest));
    }
  }
  return count;
}

// One group of contacts from up to kGroupSize picked slots; the rest of it is padding.
inline void fill_group(const CandidateArrays& candidates, const std::int32_t* picked,
                       std::size_t real, const DiskPose* pose, const DiskMotion* motion,
                       std::int32_t rest, const ContactTerms& terms, const ContactArrays& out,
                       std::size_t g, std::uint8_t* touched) {
  alignas(64) double forces[kGroupSize] = {}, stored_forces[kGroupSize] = {};
  alignas(64) long long padding_lanes[kGroupSize] = {};
  std::int32_t* first = out.first + g;
  std::int32_t* second = out.second + g;
  for (std::size_t k = 0; k < real; ++k) {
    const std::int32_t slot = picked[k];
    out.slot[g + k] = slot;
    first[k] = candidates.first[slot];
    second[k] = candidates.second[slot];
    forces[k] = candidates.normal_force[slot];
    stored_forces[k] = candidates.tangential_force[slot];
    touched[first[k]] = touched[second[k]] = 1;
  }
  for (std::size_t k = real; k < kGroupSize; ++k) {
    out.slot[g + k] = -1;
    first[k] = second[k] = rest;
    padding_lanes[k] = -1;
  }
  const Lanes force = load(forces), stored = load(stored_forces);
  const Mask padding = *reinterpret_cast<const Mask*>(padding_lanes);
  const PairGeometry pair =
      pair_geometry(fetch(pose, first), fetch(pose, second), fetch(motion, first),
                    fetch(motion, second), force, terms);
  const auto put = [&](double* to, Lanes value, double inert) {
    store(to + g, either(padding, all(inert), value));
  };
  put(out.normal_x, pair.nx, 1);
  put(out.normal_y, pair.ny, 0);
  put(out.bias_n, pair.bias_n, 1);
  store(out.bias_t + g, -terms.compliance * terms.small_step * stored);
  put(out.weight_n, pair.weight_n, 0);
  put(out.weight_t, pair.weight_t, 0);
  store(out.impulse_n + g, terms.small_step * force);
  store(out.impulse_t + g, terms.small_step * stored);
  put(out.gap_start, pair.gap_start, 1);
  store(out.stored_t + g, stored);
  put(out.gap_linear, pair.gap_linear, 1);
  put(out.offset_t, pair.offset_t, 0);
  put(out.curvature, pair.curvature, 0);
  put(out.rebound, pair.rebound, kNoRebound);
  bool some_bounce = false;
  for (std::size_t k = 0; k < real; ++k) some_bounce |= pair.bounces[k] != 0;
  out.group_rebounds[g / kGroupSize] = some_bounce;
}

std::size_t select_pairs(const CandidateArrays& candidates, const DiskPose* pose,
                         const DiskMotion* motion, const DiskPose* ahead, std::int32_t rest,
                         const ContactTerms& terms, const ContactArrays& out, std::uint8_t* touched,
                         std::int32_t* picked, std::size_t* contact_count) {
  std::size_t size = 0;
  *contact_count = 0;
  for (std::size_t colour = 0; colour < candidates.colour_count; ++colour) {
    const std::size_t count = pick(candidates, candidates.colour_start[colour],
                                   candidates.colour_start[colour + 1], ahead, rest, picked);
    for (std::size_t k = 0; k < count; k += kGroupSize, size += kGroupSize)
      fill_group(candidates, picked + k, count - k < kGroupSize ? count - k : kGroupSize, pose,
                 motion, rest, terms, out, size, touched);
    *contact_count += count;
  }
  return size;
}

}  // namespace
}  // namespace granary::dda
