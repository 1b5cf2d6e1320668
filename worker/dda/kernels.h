// The loops that cost the time, compiled once per instruction set (kernels_body.h) and chosen at
// run time. Every variant works on the same groups of kGroupSize lanes with the same operations in
// the same order and no contraction, so all of them give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/dda/disks.h"

namespace granary::dda {

// Borrowed arrays of ActiveContacts; see there for meaning and units.
struct ContactArrays {
  std::int32_t* first;
  std::int32_t* second;
  std::int32_t* slot;
  double* normal_x;
  double* normal_y;
  double* bias_n;
  double* bias_t;
  double* weight_n;
  double* weight_t;
  double* impulse_n;
  double* impulse_t;
  double* gap_start;
  double* stored_t;
};

// Borrowed arrays of a CandidateList.
struct CandidateArrays {
  const std::int32_t* first;
  const std::int32_t* second;
  const double* normal_force;
  const double* tangential_force;
  const std::uint32_t* colour_start;
  std::size_t colour_count;
};

struct ContactTerms {
  double time_step;
  double compliance;             // 1 / (K dt^2) [1/kg]
  double friction;               // tan of the friction angle
  double spin_factor;            // 2 for a disk, 0 with particle rotation switched off
  double relaxation;             // over-relaxation of the sweeps
  double margin_ratio;           // speculative margin / (r_i + r_k)
  double restitution;            // 0 = none
  double restitution_threshold;  // m/s, slower approaches do not bounce
};

// Sums of squares over the normal and tangential impulses of one sweep.
struct SweepSums {
  double change = 0;
  double total = 0;
};

struct Kernels {
  const char* name;
  // Narrow phase: appends the pairs that can act in this step, colour by colour. Returns the padded
  // number of contacts; `contact_count` counts real ones. `touched` gets 1 for their disks.
  std::size_t (*select_pairs)(const CandidateArrays&, const DiskPose*, const DiskMotion*,
                              std::int32_t rest, const ContactTerms&, const ContactArrays&,
                              std::uint8_t* touched, std::size_t* contact_count);
  // Adds the impulses kept in the contacts to the velocities (warm start).
  void (*apply_impulses)(const ContactArrays&, std::size_t count, double spin_factor, DiskMotion*);
  // One projected Gauss-Seidel sweep.
  void (*sweep)(const ContactArrays&, std::size_t count, const ContactTerms&, DiskMotion*,
                SweepSums*);
};

// The fastest variant that this processor runs.
const Kernels& kernels();

// All variants that this processor runs, for tests of their equality.
std::size_t available_kernels(const Kernels** list, std::size_t capacity);

}  // namespace granary::dda
