// Kernels of one solve per step (impulse_solver.h): warm start and sweep.
#pragma once

#include "worker/dda/kernel_lanes.h"

namespace granary::dda {
namespace {

// Adds impulse (n, t components) of a group: -P to the first disk, +P to the second. Record:
// a, b velocity, c surface speed, d inverse mass.
template <ContactEffects kEffects>
[[gnu::always_inline]] inline void add_impulse(Records& first, Records& second, Lanes nx, Lanes ny,
                                               Lanes impulse_n, Lanes impulse_t,
                                               double spin_factor) {
  const Lanes px = impulse_n * nx - impulse_t * ny;
  const Lanes py = impulse_n * ny + impulse_t * nx;
  first.a -= first.d * px;
  first.b -= first.d * py;
  second.a += second.d * px;
  second.b += second.d * py;
  if constexpr (kEffects.rotation) {
    const Lanes torque = impulse_t * spin_factor;
    first.c -= first.d * torque;
    second.c -= second.d * torque;
  }
}

// Sliding speed of the surfaces along the tangent.
[[gnu::always_inline]] inline Lanes surface_speed(const Records& first, const Records& second,
                                                  Lanes nx, Lanes ny) {
  return (second.b - first.b) * nx - (second.a - first.a) * ny - (first.c + second.c);
}

// Rolling impulse of a group: a torque impulse P_r R on the second disk and its opposite on the
// first, R = 2 r_1 r_2 / (r_1 + r_2), arms R / r.
[[gnu::always_inline]] inline void add_rolling(Records& first, Records& second, Lanes arm_first,
                                               Lanes arm_second, Lanes impulse_r,
                                               double spin_factor) {
  const Lanes torque = impulse_r * spin_factor;
  first.c -= first.d * arm_first * torque;
  second.c += second.d * arm_second * torque;
}

template <ContactEffects kEffects>
void apply_impulses(const ContactArrays& contact, std::size_t count, double spin_factor,
                    DiskMotion* motion) {
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    Records first = fetch(motion, contact.first + g);
    Records second = fetch(motion, contact.second + g);
    add_impulse<kEffects>(first, second, load(contact.normal_x + g), load(contact.normal_y + g),
                          load(contact.impulse_n + g), load(contact.impulse_t + g), spin_factor);
    if constexpr (kEffects.rolling)
      add_rolling(first, second, load(contact.arm_first + g), load(contact.arm_second + g),
                  load(contact.impulse_r + g), spin_factor);
    put_back(motion, contact.first + g, first);
    put_back(motion, contact.second + g, second);
  }
}

template <ContactEffects kEffects>
void sweep(const ContactArrays& contact, std::size_t count, const ContactTerms& terms,
           DiskMotion* motion, SweepSums* sums) {
  const Lanes compliance = all(terms.compliance), friction = all(terms.friction);
  Lanes change = {}, total = {};
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    Records first = fetch(motion, contact.first + g);
    Records second = fetch(motion, contact.second + g);
    const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
    const Lanes un = (second.a - first.a) * nx + (second.b - first.b) * ny;
    const Lanes ut = surface_speed(first, second, nx, ny);
    const Lanes old_n = load(contact.impulse_n + g), old_t = load(contact.impulse_t + g);
    const Lanes residual_n = un + load(contact.bias_n + g) + compliance * old_n;
    const Lanes residual_t = ut + load(contact.bias_t + g) + compliance * old_t;
    const Lanes new_n = larger(old_n - residual_n * load(contact.weight_n + g), Lanes{});
    const Lanes new_t = within(old_t - residual_t * load(contact.weight_t + g), friction * new_n);
    const Lanes change_n = new_n - old_n, change_t = new_t - old_t;
    add_impulse<kEffects>(first, second, nx, ny, change_n, change_t, terms.spin_factor);
    store(contact.impulse_n + g, new_n);
    store(contact.impulse_t + g, new_t);
    put_back(motion, contact.first + g, first);
    put_back(motion, contact.second + g, second);
    change += change_n * change_n + change_t * change_t;
    total += new_n * new_n + new_t * new_t;
    ++sums->evaluated.history;
    if constexpr (kEffects.rotation) ++sums->evaluated.rotation;
  }
  for (std::size_t k = 0; k < kGroupSize; ++k) {
    sums->change += change[k];
    sums->total += total[k];
  }
}

}  // namespace
}  // namespace granary::dda
