// Kernels of the small steps (small_steps.h), one body for every combination of contact laws.
#pragma once

#include "worker/core/books.h"
#include "worker/dda/kernel_one_solve.h"

namespace granary::dda {
namespace {

// Relative displacement of the bodies since the start of the step, in the contact's axes.
struct Slide {
  Lanes tangential;  // m, between the surfaces
  Lanes gap;         // m, now
  Lanes rolled;      // m, by turning against each other, at the radius R of add_rolling
  Lanes held_spin;   // m/s, of both surfaces; only where contacts turn nothing
};

template <bool kWall, ContactEffects kEffects>
[[gnu::always_inline]] inline Slide slide_of(const ContactArrays& contact, std::size_t g, Lanes nx,
                                             Lanes ny, double elapsed, const DiskShift* shift) {
  const Records first = fetch(shift, contact.first + g);
  const Records second = kWall ? Records{} : fetch(shift, contact.second + g);
  const Lanes dx = second.a - first.a, dy = second.b - first.b;
  Lanes normal = dx * nx + dy * ny, across = dy * nx - dx * ny;
  Slide slide;
  if constexpr (kWall) {
    normal += load(contact.drift_n + g) * elapsed;
    across += load(contact.drift_t + g) * elapsed;
  }
  slide.gap = load(contact.gap_linear + g) + normal;
  if constexpr (!kWall) {
    const Lanes side = load(contact.offset_t + g) + across;
    slide.gap += load(contact.curvature + g) * side * side;
  }
  slide.tangential = across - (first.c + second.c);
  if constexpr (!kEffects.rotation) slide.held_spin = (first.c + second.c) / elapsed;
  if constexpr (kEffects.rolling) {
    slide.rolled = -(load(contact.arm_first + g) * first.c);
    if constexpr (kWall)
      slide.rolled += load(contact.drift_r + g) * elapsed;
    else
      slide.rolled += load(contact.arm_second + g) * second.c;
  }
  return slide;
}

// A sum of the ledger in a register.
template <bool kBooked>
struct BookedLanes {
  Lanes sum = {};
  BookedLanes() = default;
  explicit BookedLanes(const LaneSum& before) : sum(load(before.lane)) {}
  [[gnu::always_inline]] void operator+=(const Lanes& term) {
    if constexpr (kBooked) sum += term;
  }
  double total() const {
    double all_lanes = 0;
    for (std::size_t k = 0; k < kGroupSize; ++k) all_lanes += sum[k];
    return all_lanes;
  }
};

// A sum that is rarely added to stays in memory: registers are short.
template <bool kBooked>
struct StoredLanes {
  LaneSum& target;
  [[gnu::always_inline]] void operator-=(const Lanes& term) {
    if constexpr (kBooked) store(target.lane, load(target.lane) - term);
  }
  [[gnu::always_inline]] void operator+=(const Lanes& term) {
    if constexpr (kBooked) store(target.lane, load(target.lane) + term);
  }
};

template <bool kBooked>
struct LaneSums {
  static constexpr bool kBooks = kBooked;
  using Booked = BookedLanes<kBooked>;
  using Stored = StoredLanes<kBooked>;
  SmallStepSums& target;
  Lanes change = {}, total = {};
  Booked normal_work{target.normal_work}, closing_work{target.closing_work};
  Booked tangential_work{target.tangential_work}, stick_work{target.stick_work};
  Booked stick_change{target.stick_change}, spring_loss{target.spring_loss};
  Stored collision_damping{target.collision_damping};
  Stored collision_friction{target.collision_friction}, wall_work{target.wall_work};
  Stored cohesion{target.cohesion}, rolling{target.rolling};
  EffectCounts evaluated = {};

  [[gnu::always_inline]] void store_all() const {
    for (std::size_t k = 0; k < kGroupSize; ++k) {
      target.change += change[k];
      target.total += total[k];
    }
    target.evaluated.add(evaluated);
    if constexpr (!kBooked) return;
    store(target.normal_work.lane, normal_work.sum);
    store(target.closing_work.lane, closing_work.sum);
    store(target.tangential_work.lane, tangential_work.sum);
    store(target.stick_work.lane, stick_work.sum);
    store(target.stick_change.lane, stick_change.sum);
    store(target.spring_loss.lane, spring_loss.sum);
  }
};

// The pull h F_c that a contact bears while its gap is within the range.
template <ContactEffects kEffects>
[[gnu::always_inline]] inline Lanes bond_of(Lanes gap, const ContactTerms& terms) {
  if constexpr (kEffects.cohesion)
    return either(gap < terms.cohesion_range, all(terms.cohesion * terms.small_step), Lanes{});
  return Lanes{};
}

// Books the normal impulse of a finished small step; `ratio` = c / (K h).
template <ContactEffects kEffects, typename Sums>
[[gnu::always_inline]] inline void book_normal(double ratio, Lanes gap_before, Lanes gap,
                                               Lanes impulse_n, Sums& sums) {
  const Lanes below_before = smaller(gap_before, Lanes{}), below = smaller(gap, Lanes{});
  const Lanes stretch = below_before - below;
  const Lanes work = impulse_n * (gap_before - gap);
  sums.normal_work += work;
  sums.spring_loss += stretch * either(impulse_n > 0.0, ratio * stretch, below);
  if constexpr (kEffects.cohesion) {
    sums.cohesion += either(impulse_n < 0.0, work, Lanes{});
    sums.closing_work += larger(impulse_n, Lanes{}) * (gap_before - below_before);
  } else {
    sums.closing_work += impulse_n * (gap_before - below_before);
  }
}

// Books the tangential impulse of a finished small step. That of a sticking contact is the
// spring's and the dashpot's; the spring's part S is returned for the next small step. Without
// history there is no spring.
template <ContactEffects kEffects, typename Sums>
[[gnu::always_inline]] inline Lanes book_tangential(double damping_t, Lanes moved, Lanes limit,
                                                    Lanes impulse_t, Lanes stick_before,
                                                    Sums& sums) {
  sums.tangential_work += impulse_t * moved;
  if constexpr (!kEffects.history) return impulse_t;
  const Mask sticks = (impulse_t < limit) & (impulse_t > -limit);
  const Lanes spring = within(impulse_t + damping_t * moved, limit);
  const Lanes stick = either(sticks, spring, impulse_t);
  sums.stick_work += stick * moved;
  sums.stick_change += stick * (stick - stick_before);
  return stick;
}

template <bool kWall, ContactEffects kEffects, typename Sums>
[[gnu::always_inline]] inline Lanes book_small_step(const ContactArrays& contact, std::size_t g,
                                                    const ContactTerms& terms, const Slide& slide,
                                                    Sums& sums) {
  const Lanes impulse_n = load(contact.impulse_n + g), impulse_t = load(contact.impulse_t + g);
  const Lanes gap_before = load(contact.gap_now + g);
  const double ratio = terms.damping_n / (terms.stiffness * terms.small_step);
  book_normal<kEffects>(ratio, gap_before, slide.gap, impulse_n, sums);
  const Lanes moved = slide.tangential - load(contact.slide_t + g);
  const Lanes limit = terms.friction * (impulse_n + bond_of<kEffects>(gap_before, terms));
  const Lanes stick = book_tangential<kEffects>(terms.damping_t, moved, limit, impulse_t,
                                                load(contact.stick_t + g), sums);
  if constexpr (kEffects.rolling) {
    const Lanes impulse_r = load(contact.impulse_r + g);
    sums.rolling -= impulse_r * (slide.rolled - load(contact.rolled + g)) / terms.small_step;
    if constexpr (kWall) sums.wall_work += impulse_r * load(contact.drift_r + g);
  }
  if constexpr (kWall)
    sums.wall_work += impulse_n * load(contact.drift_n + g) + impulse_t * load(contact.drift_t + g);
  // Spins that stay as they are drive what they rub against, as moving walls do.
  if constexpr (!kEffects.rotation) sums.wall_work -= impulse_t * slide.held_spin;
  return stick;
}

// The bodies of one group of contacts, and how fast they turn against each other.
template <bool kWall>
struct RollingArms {
  Lanes first, second, drift;
  RollingArms(const ContactArrays& contact, std::size_t g)
      : first(load(contact.arm_first + g)),
        second(kWall ? Lanes{} : load(contact.arm_second + g)),
        drift(kWall ? load(contact.drift_r + g) : Lanes{}) {}
  Lanes speed(const Records& a, const Records& b) const {
    return second * b.c - first * a.c + drift;
  }
};

// Which contacts close in this small step for the first time.
template <bool kWall>
[[gnu::always_inline]] inline Mask collisions(const ContactArrays& contact, std::size_t g,
                                              const ContactTerms& terms, Lanes gap, Lanes nx,
                                              Lanes ny, const Records& first,
                                              const Records& second) {
  Lanes un = (second.a - first.a) * nx + (second.b - first.b) * ny;
  if constexpr (kWall) un += load(contact.drift_n + g);
  return (load(contact.rebound + g) > kNoRebound) & (gap + un * terms.small_step < 0.0);
}

// Collisions as jumps of the velocities: a contact that closes in this small step for the first
// time gets the rigid impulse that leaves it with its rebound speed, and the friction impulse that
// stops its sliding within Coulomb's limit. The velocities at the start of the small step jump too,
// so that the jump is neither taken for an acceleration nor for a work along the way. Called for
// few groups, and through memory: inlined, it took the registers of the sweep's sums.
template <bool kWall, bool kBooked, ContactEffects kEffects>
[[gnu::noinline]] void rebound(const ContactArrays& contact, std::size_t g,
                               const ContactTerms& terms, DiskMotion* motion, DiskMotion* before,
                               SmallStepSums& target) {
  LaneSums<kBooked> sums{target};
  const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
  Records first = fetch(motion, contact.first + g);
  Records second = kWall ? Records{} : fetch(motion, contact.second + g);
  const Mask collides =
      collisions<kWall>(contact, g, terms, load(contact.gap_now + g), nx, ny, first, second);
  const Lanes wanted = load(contact.rebound + g);
  const Lanes drift_n = kWall ? load(contact.drift_n + g) : Lanes{};
  const Lanes drift_t = kWall ? load(contact.drift_t + g) : Lanes{};
  const auto normal_speed = [&](const Records& a, const Records& b) {
    return (b.a - a.a) * nx + (b.b - a.b) * ny + drift_n;
  };
  const auto sliding_speed = [&](const Records& a, const Records& b) {
    return surface_speed(a, b, nx, ny) + drift_t;
  };
  const Lanes un = normal_speed(first, second), ut = sliding_speed(first, second);
  const Lanes mobility_n = first.d + second.d;
  const Lanes mobility_t = (1.0 + terms.spin_factor) * mobility_n;
  const Lanes impulse_n = either(collides, (wanted - un) / mobility_n, Lanes{});
  const Lanes impulse_t =
      either(collides, within(-ut / mobility_t, terms.friction * impulse_n), Lanes{});
  add_impulse<kEffects>(first, second, nx, ny, impulse_n, impulse_t, terms.spin_factor);

  Records first_before = fetch(before, contact.first + g);
  Records second_before = kWall ? Records{} : fetch(before, contact.second + g);
  sums.collision_damping -= impulse_n * normal_speed(first_before, second_before) +
                            0.5 * impulse_n * impulse_n * mobility_n;
  sums.collision_friction -= impulse_t * sliding_speed(first_before, second_before) +
                             0.5 * impulse_t * impulse_t * mobility_t;
  if constexpr (kWall) sums.wall_work += impulse_n * drift_n + impulse_t * drift_t;
  if constexpr (!kEffects.rotation) sums.wall_work -= impulse_t * (first.c + second.c);
  add_impulse<kEffects>(first_before, second_before, nx, ny, impulse_n, impulse_t,
                        terms.spin_factor);
  if constexpr (kEffects.rolling) {
    const RollingArms<kWall> arms(contact, g);
    const Lanes mobility_r = terms.spin_factor * (first.d * arms.first * arms.first +
                                                  second.d * arms.second * arms.second);
    const Lanes impulse_r =
        either(collides, within(-arms.speed(first, second) / mobility_r, terms.rolling * impulse_n),
               Lanes{});
    sums.rolling -= impulse_r * arms.speed(first_before, second_before) +
                    0.5 * impulse_r * impulse_r * mobility_r;
    if constexpr (kWall) sums.wall_work += impulse_r * arms.drift;
    add_rolling(first, second, arms.first, arms.second, impulse_r, terms.spin_factor);
    add_rolling(first_before, second_before, arms.first, arms.second, impulse_r, terms.spin_factor);
  }
  put_back(motion, contact.first + g, first);
  put_back(before, contact.first + g, first_before);
  if constexpr (!kWall) put_back(motion, contact.second + g, second);
  if constexpr (!kWall) put_back(before, contact.second + g, second_before);
  store(contact.rebound + g, either(collides, all(kNoRebound), wanted));
}

// Rolling resistance: stops the bodies turning against each other within mu_r times what presses
// them together.
template <bool kWall, typename Sums>
[[gnu::always_inline]] inline void resist_rolling(const ContactArrays& contact, std::size_t g,
                                                  const ContactTerms& terms, Lanes pressed,
                                                  Records& first, Records& second, Sums& sums) {
  const RollingArms<kWall> arms(contact, g);
  const Lanes old_r = load(contact.impulse_r + g);
  const Lanes new_r = within(old_r - arms.speed(first, second) * load(contact.weight_r + g),
                             terms.rolling * pressed);
  const Lanes change_r = new_r - old_r;
  add_rolling(first, second, arms.first, arms.second, change_r, terms.spin_factor);
  store(contact.impulse_r + g, new_r);
  sums.change += change_r * change_r;
  sums.total += new_r * new_r;
}

template <ContactEffects kEffects>
[[gnu::always_inline]] inline void count_evaluations(EffectCounts& evaluated) {
  if constexpr (kEffects.rotation) ++evaluated.rotation;
  if constexpr (kEffects.history) ++evaluated.history;
  if constexpr (kEffects.cohesion) ++evaluated.cohesion;
  if constexpr (kEffects.rolling) ++evaluated.rolling;
}

template <bool kWall, bool kFirst, ContactEffects kEffects, typename Sums>
void small_sweep(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                 const SmallStep& small, const DiskShift* shift, DiskMotion* motion,
                 DiskMotion* before, Sums& sums) {
  const double per_step = 1 / terms.small_step;
  const double recovery = terms.compliance_n / terms.compliance;
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
    const Lanes old_n = load(contact.impulse_n + g), old_t = load(contact.impulse_t + g);
    Lanes stick = old_t, gap;
    if constexpr (kFirst) {
      const Slide slide = slide_of<kWall, kEffects>(contact, g, nx, ny, small.elapsed, shift);
      gap = slide.gap;
      if (small.closes) stick = book_small_step<kWall, kEffects>(contact, g, terms, slide, sums);
      store(contact.gap_now + g, gap);
      store(contact.slide_t + g, slide.tangential);
      if constexpr (kEffects.history) store(contact.stick_t + g, stick);
      if constexpr (kEffects.rolling) store(contact.rolled + g, slide.rolled);
    } else {
      gap = load(contact.gap_now + g);
      if constexpr (kEffects.history) stick = load(contact.stick_t + g);
    }
    Records first = fetch(motion, contact.first + g);
    Records second = kWall ? Records{} : fetch(motion, contact.second + g);
    if (contact.group_rebounds[g / kGroupSize] &&
        any(collisions<kWall>(contact, g, terms, gap, nx, ny, first, second))) {
      rebound<kWall, Sums::kBooks, kEffects>(contact, g, terms, motion, before, sums.target);
      first = fetch(motion, contact.first + g);
      if constexpr (!kWall) second = fetch(motion, contact.second + g);
    }
    Lanes un = (second.a - first.a) * nx + (second.b - first.b) * ny;
    Lanes ut = surface_speed(first, second, nx, ny);
    if constexpr (kWall) un += load(contact.drift_n + g), ut += load(contact.drift_t + g);
    const bool one_mass = terms.weight_n > 0;
    const Lanes weight_n = one_mass ? all(terms.weight_n) : load(contact.weight_n + g);
    const Lanes weight_t = one_mass ? all(terms.weight_t) : load(contact.weight_t + g);
    const Lanes bond = bond_of<kEffects>(gap, terms);
    const Lanes bias = gap * either(gap > 0.0, all(per_step), all(per_step * recovery));
    const Lanes new_n =
        larger(old_n - (un + bias + terms.compliance_n * old_n) * weight_n, Lanes{} - bond);
    Lanes pressed = new_n;
    if constexpr (kEffects.cohesion) pressed += bond;
    Lanes wanted_t = ut;
    if constexpr (kEffects.history) wanted_t += terms.compliance_t * (old_t - stick);
    const Lanes new_t = within(old_t - wanted_t * weight_t, terms.friction * pressed);
    const Lanes change_n = new_n - old_n, change_t = new_t - old_t;
    add_impulse<kEffects>(first, second, nx, ny, change_n, change_t, terms.spin_factor);
    if constexpr (kEffects.rolling)
      resist_rolling<kWall>(contact, g, terms, pressed, first, second, sums);
    store(contact.impulse_n + g, new_n);
    store(contact.impulse_t + g, new_t);
    put_back(motion, contact.first + g, first);
    if constexpr (!kWall) put_back(motion, contact.second + g, second);
    sums.change += change_n * change_n + change_t * change_t;
    sums.total += new_n * new_n + new_t * new_t;
    count_evaluations<kEffects>(sums.evaluated);
  }
}

template <bool kWall, bool kBooked, ContactEffects kEffects>
void small_sweep_booked(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                        const SmallStep& small, const DiskShift* shift, DiskMotion* motion,
                        DiskMotion* before, SmallStepSums* sums) {
  LaneSums<kBooked> lanes{*sums};
  if (small.first_sweep)
    small_sweep<kWall, true, kEffects>(contact, count, terms, small, shift, motion, before, lanes);
  else
    small_sweep<kWall, false, kEffects>(contact, count, terms, small, shift, motion, before, lanes);
  lanes.store_all();
}

template <bool kWall, ContactEffects kEffects>
void small_sweep_any(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                     const SmallStep& small, const DiskShift* shift, DiskMotion* motion,
                     DiskMotion* before, SmallStepSums* sums) {
  const auto sweep = small.books && core::kBooks ? small_sweep_booked<kWall, core::kBooks, kEffects>
                                                 : small_sweep_booked<kWall, false, kEffects>;
  sweep(contact, count, terms, small, shift, motion, before, sums);
}

template <bool kWall, bool kBooked, ContactEffects kEffects>
void close_booked(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                  const SmallStep& small, const DiskShift* shift, SmallStepSums* sums,
                  ContactSums* contact_sums) {
  LaneSums<kBooked> lanes{*sums};
  BookedLanes<core::kBooks> overlap2, stick2;
  Lanes worst = {};
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
    const Slide slide = slide_of<kWall, kEffects>(contact, g, nx, ny, small.elapsed, shift);
    const Lanes stick = book_small_step<kWall, kEffects>(contact, g, terms, slide, lanes);
    const Lanes overlap = larger(-slide.gap, Lanes{});
    overlap2 += overlap * overlap;
    if constexpr (kEffects.history) {
      store(contact.impulse_t + g, stick);
      stick2 += stick * stick;
    }
    if constexpr (core::kBooks) worst = larger(worst, -load(contact.gap_start + g));
  }
  lanes.store_all();
  contact_sums->overlap2 += overlap2.total();
  contact_sums->stick2 += stick2.total();
  for (std::size_t k = 0; k < kGroupSize; ++k) {
    if (worst[k] > contact_sums->worst_overlap) contact_sums->worst_overlap = worst[k];
  }
}

template <bool kWall, ContactEffects kEffects>
void close_contacts(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
                    const SmallStep& small, const DiskShift* shift, SmallStepSums* sums,
                    ContactSums* contact_sums) {
  const auto close = small.books && core::kBooks ? close_booked<kWall, core::kBooks, kEffects>
                                                 : close_booked<kWall, false, kEffects>;
  close(contact, count, terms, small, shift, sums, contact_sums);
}

template <bool kBooked>
double advance(const std::uint32_t* index, std::size_t count, double small_step, const double* mass,
               DiskMotion* motion, DiskMotion* before, DiskShift* shift) {
  Quad sum = {};
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t i = index[k];
    Quad& v = *reinterpret_cast<Quad*>(motion + i);
    Quad& old = *reinterpret_cast<Quad*>(before + i);
    Quad& moved = *reinterpret_cast<Quad*>(shift + i);
    const Quad end = v, gain = end - old;
    moved += small_step * end;
    if constexpr (kBooked) sum += mass[i] * (gain * gain);
    old = end;
    v = end + gain;
  }
  return 0.5 * (sum[0] + sum[1] + 0.5 * sum[2]);
}

// Moves the disks through a small step; see Kernels.
double advance_disks(const std::uint32_t* index, std::size_t count, double small_step, bool books,
                     const double* mass, DiskMotion* motion, DiskMotion* before, DiskShift* shift) {
  const auto move = books && core::kBooks ? advance<core::kBooks> : advance<false>;
  return move(index, count, small_step, mass, motion, before, shift);
}

}  // namespace
}  // namespace granary::dda
