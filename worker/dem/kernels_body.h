// Body of the kernels, included by one source file per instruction set after its lanes_*.h, which
// defines Lanes (16 floats), Mask and the moves between records and lanes. Internal linkage
// throughout, so that nothing compiled for a large instruction set can leak into the others. Law:
// worker/dem/README.md, contact_law.cpp is the same in plain words. Here the normal points from the
// partner to the grain, so that approach speeds are negative. flatten: with a kernel for each
// combination of effects the compiler would rather call the parts than inline them.

#include "worker/core/books.h"
#include "worker/dem/kernels.h"

namespace granary::dem {
namespace {

struct Vec {
  Lanes x, y, z;
};
inline Vec operator+(const Vec& a, const Vec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator-(const Vec& a, const Vec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec operator*(const Vec& a, const Lanes& s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Lanes dot(const Vec& a, const Vec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec only(const Mask& m, const Vec& v) {
  return {only(m, v.x), only(m, v.y), only(m, v.z)};
}
inline Vec select(const Mask& m, const Vec& a, const Vec& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

// Makes the compiler load indices anew: thirty-two of them do not stay in registers, and it would
// rather spill them than read them again.
inline void read_again(const std::uint32_t*& indices) {
  asm("" : "+r"(indices));
}

inline std::uint32_t valid_lanes(std::size_t count, std::size_t group_start) {
  const std::size_t left = count - group_start;
  return left >= kLanes ? 0xffffU : (1U << left) - 1U;
}

// Sixteen contacts before the law acts on them.
struct Encounter {
  Vec normal;  // unit, from the partner to the grain
  Lanes overlap;
  Vec velocity;  // of the grain relative to its partner
  Vec surface;   // R w of both, summed
  Vec spin;      // relative, w_a - w_b; rolling friction only
  Mask touching;
};

struct Response {
  Vec force;    // on the grain
  Vec turning;  // torque / R, the same on both
  Vec rolling;  // torque on the grain, its negative on the partner
};

struct LaneSums {
  Lanes normal_damping = all(0), friction = all(0), rolling = all(0), overlap_ratio = all(0);
  std::uint64_t contacts = 0;

  void add_to(ContactSums& sums, float time_step) const {
    sums.normal_damping += static_cast<double>(time_step) * sum(normal_damping);
    sums.friction += sum(friction);
    sums.rolling += static_cast<double>(time_step) * sum(rolling);
    const float ratio = largest(overlap_ratio);
    if (!(ratio <= sums.largest_overlap_ratio)) sums.largest_overlap_ratio = ratio;
    sums.contacts += contacts;
  }
};

// What sixteen contacts remember of the last step.
struct Memory {
  Vec spring;
  Vec velocity;
  Lanes touched;
};

struct Tangential {
  Vec force, spring;
  Lanes spring_loss;  // energy of the elongation that was cut off at the Coulomb limit
};

// Spring and dashpot in the tangent plane; the spring is shortened to the Coulomb limit.
template <ContactEffects kEffects>
inline Tangential slide(const Encounter& c, const Vec& sliding, const Vec& spring_before,
                        const Lanes& limit, const LawTables& laws, const Kinds& kinds, Lanes dt) {
  const Vec dashpot = sliding * lookup(laws.tangential_damping, kinds);
  if constexpr (!kEffects.tangential_history) {
    const Lanes size = square_root(dot(dashpot, dashpot));
    const Lanes kept = smaller(limit / size, all(1));
    return {dashpot * (all(0) - kept), {all(0), all(0), all(0)}, all(0)};
  } else {
    const Lanes stiffness = lookup(laws.tangential_stiffness, kinds);
    const Vec in_plane = spring_before - c.normal * dot(spring_before, c.normal);
    const Vec step = sliding * dt;
    const Vec trial_spring = in_plane + step;
    const Vec trial = trial_spring * stiffness + dashpot;  // against the force
    const Lanes size = square_root(dot(trial, trial));
    const Lanes kept = smaller(limit / size, all(1));
    const Vec pull = trial * kept;
    const Vec cut_spring = (pull - dashpot) * lookup(laws.inverse_tangential_stiffness, kinds);
    const Vec spring = select(less(kept, all(1)), cut_spring, trial_spring);
    const Vec slip = trial_spring - spring;
    const Lanes loss = stiffness * dot(slip, spring + (slip - step) * all(0.5F));
    return {pull * all(-1), spring, loss};
  }
}

// Rolling torque on the grain, bounded by what stops the relative spin after the contact's own
// torque.
inline Vec roll(const Encounter& c, const Vec& turning, const Lanes& pressing,
                const LawTables& laws, const Kinds& kinds) {
  const Vec spin_after = c.spin + turning * lookup(laws.spin_response, kinds);
  const Lanes rate = square_root(dot(spin_after, spin_after));
  const Lanes coulomb = lookup(laws.rolling_arm, kinds) * pressing;
  const Lanes stopping = lookup(laws.stopping, kinds) * rate;
  const Lanes share = smaller(coulomb, stopping) / rate;
  return only(less(all(0), rate), spin_after * (all(0) - share));
}

// Dissipation is booked with the mean velocity of a step, half now and half when the next step
// knows the velocity it led to; a contact that opens gives up what its spring still held.
template <ContactEffects kEffects>
inline void book(const Encounter& c, const Vec& velocity, const Lanes& vn, const Vec& sliding,
                 const Memory& memory, const Tangential& tangential, const LawTables& laws,
                 const Kinds& kinds, Lanes dt, LaneSums& sums) {
  const Lanes half = all(0.5F);
  const Mask before = less(all(0), memory.touched);
  const Lanes previous_n = dot(memory.velocity, c.normal);
  const Lanes twice_n = only(c.touching, vn * vn) + only(before, vn * previous_n);
  sums.normal_damping = sums.normal_damping + half * lookup(laws.normal_damping, kinds) * twice_n;
  if constexpr (!kEffects.tangential_history) {
    const Lanes twice_power = only(c.touching, dot(tangential.force, sliding)) +
                              only(before, dot(memory.spring, sliding));
    sums.friction = sums.friction - half * twice_power * dt;
  } else {
    const Lanes twice_t = only(c.touching, dot(sliding, sliding)) +
                          only(before, dot(velocity, memory.velocity) - vn * previous_n);
    sums.friction = sums.friction + half * lookup(laws.tangential_damping, kinds) * twice_t * dt;
    const Lanes held = half * lookup(laws.tangential_stiffness, kinds) *
                       dot(memory.spring, memory.spring + sliding * dt);
    sums.friction = sums.friction + select(c.touching, tangential.spring_loss, only(before, held));
  }
}

// One step of the law for a group; updates memory and sums.
template <ContactEffects kEffects>
inline Response respond(const Encounter& c, Memory& memory, const LawTables& laws,
                        const Kinds& kinds, Lanes dt, LaneSums& sums) {
  const Vec velocity = kEffects.spin ? c.velocity + cross(c.normal, c.surface) : c.velocity;
  const Lanes vn = dot(c.velocity, c.normal);
  const Vec sliding = velocity - c.normal * vn;
  const Lanes pressing =
      lookup(laws.normal_stiffness, kinds) * c.overlap - lookup(laws.normal_damping, kinds) * vn;
  const Lanes size = larger(pressing, all(0) - pressing);
  const Lanes limit = lookup(laws.friction, kinds) * size;
  const Tangential tangential = slide<kEffects>(c, sliding, memory.spring, limit, laws, kinds, dt);
  if constexpr (core::kBooks)
    book<kEffects>(c, velocity, vn, sliding, memory, tangential, laws, kinds, dt, sums);
  memory.spring =
      only(c.touching, kEffects.tangential_history ? tangential.spring : tangential.force);
  if constexpr (core::kBooks) memory.velocity = velocity;
  memory.touched = only(c.touching, all(1));
  if constexpr (core::kBooks)
    sums.overlap_ratio = larger(sums.overlap_ratio,
                                only(c.touching, c.overlap * lookup(laws.inverse_radius, kinds)));
  sums.contacts += static_cast<std::uint64_t>(__builtin_popcount(bits(c.touching)));

  Lanes normal_force = pressing;
  if constexpr (kEffects.cohesion) normal_force = pressing - lookup(laws.cohesion, kinds);
  Response response;
  response.force = only(c.touching, c.normal * normal_force + tangential.force);
  if constexpr (kEffects.spin) {
    response.turning = only(c.touching, cross(tangential.force, c.normal));
  } else {
    response.turning = {all(0), all(0), all(0)};
  }
  if constexpr (kEffects.rolling_friction) {
    response.rolling = only(c.touching, roll(c, response.turning, size, laws, kinds));
    // The mean spin of the step, as far as this contact changes it.
    const Vec mean = c.spin + (response.turning * lookup(laws.spin_response, kinds)) * all(0.5F);
    sums.rolling = sums.rolling - only(c.touching, dot(response.rolling, mean));
  }
  return response;
}

inline Memory recall(const Recollection& r) {
  return {{r.sx, r.sy, r.sz}, {r.vx, r.vy, r.vz}, r.touched};
}
inline Recollection record(const Memory& m) {
  return {m.spring.x, m.spring.y, m.spring.z, m.touched, m.velocity.x, m.velocity.y, m.velocity.z};
}

template <ContactEffects kEffects>
inline Encounter meet_pair(const ContactTask& task, const std::uint32_t* first,
                           const std::uint32_t* second, std::uint32_t valid, const Kinds& kinds) {
  const Rows rows = fetch_difference(task.block.motion, first, second);
  const Vec offset{rows.px, rows.py, rows.pz};
  const Lanes distance = square_root(dot(offset, offset));
  Encounter c;
  c.overlap = lookup(task.laws->reach, kinds) - distance;
  c.touching = less(all(0), c.overlap) & mask_of(valid);
  c.normal = offset * (all(1) / distance);
  c.velocity = {rows.vx, rows.vy, rows.vz};
  if constexpr (kEffects.rolling_friction) {
    const Columns a = fetch_surface(task.block.surface, first);
    const Columns b = fetch_surface(task.block.surface, second);
    const Vec wa{a.x, a.y, a.z}, wb{b.x, b.y, b.z};
    c.surface = wa + wb;
    c.spin = wa * lookup(task.laws->inverse_radius_a, kinds) -
             wb * lookup(task.laws->inverse_radius_b, kinds);
  } else if constexpr (kEffects.spin) {
    read_again(first);
    read_again(second);
    const Columns both = fetch_surface_sum(task.block.surface, first, second);
    c.surface = {both.x, both.y, both.z};
  }
  return c;
}

template <ContactEffects kEffects>
inline Encounter meet_wall(const ContactTask& task, std::size_t g, const Kinds& kinds) {
  const std::uint32_t* first = task.slots.first + g;
  const Rows rows = fetch_from(task.block.motion, first, task.slots.foot + g);
  const Kinds walls = indices_at(task.slots.second + g, task.walls->count);
  Encounter c;
  c.normal = {lookup(task.walls->normal_x, walls), lookup(task.walls->normal_y, walls),
              lookup(task.walls->normal_z, walls)};
  c.overlap = all(0) - dot({rows.px, rows.py, rows.pz}, c.normal);
  c.touching = less(all(0), c.overlap) & mask_of(valid_lanes(task.slots.count, g));
  c.velocity = {rows.vx, rows.vy, rows.vz};
  if constexpr (kEffects.spin) {
    const Columns own = fetch_surface(task.block.surface, first);
    c.surface = {own.x, own.y, own.z};
    if constexpr (kEffects.rolling_friction) {
      c.spin = c.surface * lookup(task.laws->inverse_radius_a, kinds);
    }
  }
  return c;
}

// Gathers the slots whose grains are near each other, or were in the last step and have parted.
inline std::size_t find_active(const ContactTask& task) {
  const SlotArrays& slots = task.slots;
  std::size_t active = 0;
  for (std::size_t g = 0; g < slots.count; g += kLanes) {
    const Kinds kinds = kinds_at(slots.kind + g, task.laws->kinds);
    const Columns columns = fetch_offset(task.block.motion, slots.first + g, slots.second + g);
    const Vec offset{columns.x, columns.y, columns.z};
    const Mask is_near = less(dot(offset, offset), lookup(task.laws->near_square, kinds));
    const std::uint32_t near = bits(is_near) & valid_lanes(slots.count, g);
    std::uint16_t& was_near = slots.near[g / kLanes];
    const std::uint32_t keep = near | was_near;
    was_near = static_cast<std::uint16_t>(near);
    write_active(slots, active, static_cast<std::uint32_t>(g), keep);
    active += static_cast<std::size_t>(__builtin_popcount(keep));
  }
  for (std::size_t k = active; k < active + kLanes; ++k) {
    slots.active[0][k] = static_cast<std::uint32_t>(slots.count);
    slots.active[1][k] = slots.active[2][k] = 0;
  }
  return active;
}

template <ContactEffects kEffects>
[[gnu::flatten]] void pair_contacts(const ContactTask& task, ContactSums& sums) {
  LaneSums lane_sums;
  const LawTables& laws = *task.laws;
  const Lanes dt = all(task.time_step);
  const std::size_t active = find_active(task);
  for (std::size_t g = 0; g < active; g += kLanes) {
    const std::uint32_t* slot = task.slots.active[0] + g;
    const std::uint32_t* first = task.slots.active[1] + g;
    const std::uint32_t* second = task.slots.active[2] + g;
    const Kinds kinds = kinds_of(task.slots.kind, slot, laws.kinds);
    const Encounter c = meet_pair<kEffects>(task, first, second, valid_lanes(active, g), kinds);
    Memory memory = recall(fetch_history(task.slots.history, slot));
    const Response r = respond<kEffects>(c, memory, laws, kinds, dt, lane_sums);
    read_again(slot);
    store_history(task.slots.history, slot, record(memory));
    Vec turning_a = r.turning, turning_b = r.turning;
    if constexpr (kEffects.rolling_friction) {
      turning_a = turning_a + r.rolling * lookup(laws.inverse_radius_a, kinds);
      turning_b = turning_b - r.rolling * lookup(laws.inverse_radius_b, kinds);
    }
    read_again(first);
    read_again(second);
    add_to_pairs<kEffects.spin, kEffects.rolling_friction>(
        task.block.load, first, second, {turning_a.x, turning_a.y, turning_a.z},
        {turning_b.x, turning_b.y, turning_b.z}, {r.force.x, r.force.y, r.force.z});
  }
  lane_sums.add_to(sums, task.time_step);
}

template <ContactEffects kEffects>
[[gnu::flatten]] void wall_contacts(const ContactTask& task, ContactSums& sums) {
  LaneSums lane_sums;
  const LawTables& laws = *task.laws;
  const Lanes dt = all(task.time_step);
  for (std::size_t g = 0; g < task.slots.count; g += kLanes) {
    const Kinds kinds = kinds_at(task.slots.kind + g, laws.kinds);
    const Encounter c = meet_wall<kEffects>(task, g, kinds);
    Memory memory = recall(fetch_history(task.slots.history + g));
    if ((bits(c.touching) | bits(less(all(0), memory.touched))) == 0) continue;
    const Response r = respond<kEffects>(c, memory, laws, kinds, dt, lane_sums);
    store_history(task.slots.history + g, record(memory));
    Vec turning = r.turning;
    if constexpr (kEffects.rolling_friction) {
      turning = turning + r.rolling * lookup(laws.inverse_radius_a, kinds);
    }
    add_to_grains<kEffects.spin>(task.block.load, task.slots.first + g,
                                 {turning.x, turning.y, turning.z},
                                 {r.force.x, r.force.y, r.force.z});
  }
  lane_sums.add_to(sums, task.time_step);
}

std::size_t prune(const PruneTask& task) {
  std::size_t kept = 0;
  const Lanes horizon = all(task.horizon), margin = all(task.margin);
  for (std::size_t g = 0; g < task.count; g += kLanes) {
    const Kinds kinds = kinds_at(task.kind + g, task.laws->kinds);
    const Rows rows = fetch_difference(task.motion, task.first + g, task.second + g);
    const Vec offset{rows.px, rows.py, rows.pz}, velocity{rows.vx, rows.vy, rows.vz};
    const Lanes distance = square_root(dot(offset, offset));
    const Lanes gap = distance - lookup(task.laws->reach, kinds);
    const Lanes approach = smaller(dot(offset, velocity) / distance, all(0));
    const std::uint32_t keep =
        bits(less(gap + approach * horizon, margin)) & valid_lanes(task.count, g);
    kept += write_slots(task.survivors + kept, static_cast<std::uint32_t>(g), keep,
                        bits(less(gap, all(0))));
  }
  return kept;
}

std::size_t search(const SearchTask& task) {
  std::size_t count = 0;
  for (std::uint32_t a = task.begin; a < task.end; ++a) {
    const Lanes x = all(task.x[a]), y = all(task.y[a]), z = all(task.z[a]);
    const Lanes reach = all(task.radius[a] + task.skin);
    const auto look = [&](std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t b = begin; b < end; b += kLanes) {
        const Lanes dx = load_any(task.x + b) - x;
        const Lanes dy = load_any(task.y + b) - y;
        const Lanes dz = load_any(task.z + b) - z;
        const Lanes both = load_any(task.radius + b) + reach;
        const Mask near = less(dx * dx + dy * dy + dz * dz, both * both);
        const std::uint32_t hits = bits(near) & valid_lanes(end, b);
        count += write_pairs(task.first + count, task.second + count, a - task.origin,
                             b - task.origin, hits);
      }
    };
    look(a + 1, task.row_end);
    for (const auto& row : task.rows) look(row[0], row[1]);
  }
  return count;
}

template <std::size_t... kRows>
constexpr Kernels make_kernels(const char* name, std::index_sequence<kRows...>) {
  return {name,
          {pair_contacts<kEffectCombinations[kRows].effects>...},
          {wall_contacts<kEffectCombinations[kRows].effects>...},
          {integrate<false, false>, integrate<false, true>},
          {integrate<true, false>, integrate<true, true>},
          prune,
          search};
}

constexpr Kernels make_kernels(const char* name) {
  return make_kernels(name, std::make_index_sequence<kEffectCombinationCount>());
}

}  // namespace
}  // namespace granary::dem
