// Narrow phase of disk pairs: which candidates can act in the step, and their geometry.
#pragma once

#include "worker/dda/kernel_lanes.h"

namespace granary::dda {
namespace {

struct PairGeometry {
  Lanes nx, ny, un, gap_start, gap_linear, offset_t, curvature, rebound;
  Mask bounces, collides;
};

// The normal is taken where the velocities of the last step lead by `normal_time`; at the present
// positions when that would turn it by more than 60 deg (a pair that would pass through itself).
[[gnu::always_inline]] inline PairGeometry pair_geometry(const Records& p1, const Records& p2,
                                                         const Records& v1, const Records& v2,
                                                         Lanes force, const ContactTerms& terms) {
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
  const Mask bounces =
      (un < -terms.restitution_threshold) & (gap_linear + un * terms.time_step < 0.0);
  const Mask unforced = force <= 0.0;  // since it closes, for the first time
  return {nx,         ny,
          un,         distance - reach,
          gap_linear, dy * nx - dx * ny,
          0.5 / base, either(bounces & unforced, -terms.restitution * un, all(kNoRebound)),
          bounces,    bounces & unforced};
}

// Bias of the normal of one solve, restitution included [m/s].
[[gnu::always_inline]] inline Lanes bias_of(const PairGeometry& pair, const ContactTerms& terms) {
  const Lanes bias = pair.gap_linear / terms.time_step;
  if (!(terms.restitution > 0)) return bias;
  return either(pair.bounces, smaller(bias, terms.restitution * pair.un), bias);
}

// Slots of the candidates of [begin, end) that can act: near at the end of the step, or in force.
[[gnu::always_inline]] inline std::size_t pick(const CandidateArrays& candidates, std::size_t begin,
                                               std::size_t end, const DiskPose* ahead,
                                               std::int32_t rest, std::int32_t* picked) {
  std::size_t count = 0;
  for (std::size_t g = begin; g < end; g += kGroupSize) {
    const Records a = fetch(ahead, candidates.first + g), b = fetch(ahead, candidates.second + g);
    const Lanes dx = b.a - a.a, dy = b.b - a.b, reach = a.c + b.c;
    const Mask acts =
        (dx * dx + dy * dy < reach * reach) | (load(candidates.normal_force + g) != 0.0);
    for (std::size_t k = 0; k < kGroupSize; ++k) {
      picked[count] = static_cast<std::int32_t>(g + k);
      count += static_cast<std::size_t>((acts[k] != 0) & (candidates.first[g + k] != rest));
    }
  }
  return count;
}

// One group of contacts from up to kGroupSize picked slots; the rest of it is padding.
[[gnu::always_inline]] inline void fill_group(const CandidateArrays& candidates,
                                              const std::int32_t* picked, std::size_t real,
                                              const DiskPose* pose, const DiskMotion* motion,
                                              std::int32_t rest, const ContactTerms& terms,
                                              const ContactArrays& out, std::size_t g,
                                              std::uint8_t* touched) {
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
  const Records v1 = fetch(motion, first), v2 = fetch(motion, second);
  const PairGeometry pair =
      pair_geometry(fetch(pose, first), fetch(pose, second), v1, v2, force, terms);
  const auto put = [&](double* to, Lanes value, double inert) {
    store(to + g, either(padding, all(inert), value));
  };
  put(out.normal_x, pair.nx, 1);
  put(out.normal_y, pair.ny, 0);
  if (terms.weight_n == 0) {
    const Lanes inverse_mass = v1.d + v2.d;
    put(out.weight_n, terms.relaxation / (inverse_mass + terms.compliance_n), 0);
    put(out.weight_t,
        terms.relaxation / ((1.0 + terms.spin_factor) * inverse_mass + terms.compliance_t), 0);
  }
  if (terms.small_step == terms.time_step) {  // one solve
    put(out.bias_n, bias_of(pair, terms), 1);
    store(out.bias_t + g, -terms.compliance * terms.small_step * stored);
  }
  store(out.impulse_n + g, terms.small_step * force);
  store(out.impulse_t + g, terms.small_step * stored);
  put(out.gap_start, pair.gap_start, 1);
  store(out.stored_t + g, stored);
  put(out.gap_linear, pair.gap_linear, 1);
  put(out.offset_t, pair.offset_t, 0);
  put(out.curvature, pair.curvature, 0);
  put(out.rebound, pair.rebound, kNoRebound);
  bool some_bounce = false;
  for (std::size_t k = 0; k < real; ++k) some_bounce |= pair.collides[k] != 0;
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
