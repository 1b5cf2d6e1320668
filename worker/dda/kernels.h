// The loops that cost the time, compiled once per instruction set (kernel_*.h) and chosen at run
// time, and within one once per combination of contact laws (contact_effects.h). Every variant
// works on the same groups of kGroupSize lanes with the same operations in the same order and no
// contraction, so all of them give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/dda/contact_effects.h"
#include "worker/dda/contact_list.h"
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
  double* gap_linear;
  double* offset_t;
  double* curvature;
  double* gap_now;
  double* stick_t;
  double* slide_t;
  double* rebound;
  double* drift_n;
  double* drift_t;
  std::uint8_t* group_rebounds;
  // Rolling resistance only; see there.
  double* arm_first;
  double* arm_second;
  double* weight_r;
  double* impulse_r;
  double* rolled;
  double* drift_r;
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
  double small_step;  // time_step / whole number; impulses belong to it
  double stiffness;   // K [N/m]
  double damping_n;   // c [N s/m] of the dashpots
  double damping_t;
  double compliance;    // 1 / (K h^2) [1/kg], h = small_step
  double compliance_n;  // 1 / (K h^2 + c h) [1/kg]
  double compliance_t;
  double friction;               // tan of the friction angle
  double rolling;                // mu_r
  double cohesion;               // F_c [N]
  double cohesion_range;         // m, largest gap of a cohesive contact
  double spin_factor;            // 2 for a disk, 0 with particle rotation switched off
  double relaxation;             // over-relaxation of the sweeps
  double weight_n, weight_t;     // of every contact, where all disks have one mass; 0: each its own
  double normal_time;            // normals are taken where the velocities lead by then [s]
  double restitution;            // 0 = none
  double restitution_threshold;  // m/s, slower approaches do not bounce
};

// Sums of squares over the normal and tangential impulses of one sweep.
struct SweepSums {
  double change = 0;
  double total = 0;
  EffectCounts evaluated;
};

// Small steps: what a sweep needs besides ContactTerms, and what it adds up.
struct SmallStep {
  double elapsed;    // s, since the start of the step
  bool first_sweep;  // of this small step: ends the small step before
  bool closes;       // there was one in this step
  bool books;        // adds up what it did to the energies
};
// A sum of the ledger, lane by lane: adding up the lanes after every sweep would cost more than the
// terms do.
struct alignas(64) LaneSum {
  double lane[kGroupSize] = {};
  double total() const {
    double sum = 0;
    for (const double part : lane) sum += part;
    return sum;
  }
};
// The ledger's sums run over a whole step, and factors common to all contacts are left to its end:
// add_list() in small_steps.cpp puts together what the laws did. P_n, P_t = impulses of a small
// step, o', g' and o, g = overlaps and gaps at its start and end, d = tangential displacement in
// it, S', S = the tangential spring's impulse at its start and end.
struct SmallStepSums {
  // N m s
  LaneSum normal_work;      // P_n (g' - g)
  LaneSum closing_work;     // P_n times the part of it before the gap closed
  LaneSum tangential_work;  // P_t d
  LaneSum stick_work;       // S d
  LaneSum stick_change;     // S (S - S') [N2 s2]
  // (o - o') c / (K h) (o - o'); of a contact that let go, what its spring held: (o' - o) o [m2]
  LaneSum spring_loss;
  // J
  LaneSum collision_damping;  // J
  LaneSum collision_friction;
  LaneSum wall_work;
  LaneSum cohesion;
  LaneSum rolling;
  double change = 0, total = 0;  // N2 s2, as SweepSums; of one sweep
  EffectCounts evaluated;
  double unused[2] = {};  // no padding: tests compare bytes
};
// Sums over the contacts of a step.
struct ContactSums {
  double overlap2 = 0;       // m2, at the end
  double stick2 = 0;         // N2 s2, of the tangential springs, last small step
  double worst_overlap = 0;  // m, at the start
};

// Kernels of one combination of contact laws.
struct ContactKernels {
  // One projected Gauss-Seidel sweep of a step with one solve; nullptr: not for these laws.
  void (*sweep)(const ContactArrays&, std::size_t count, const ContactTerms&, DiskMotion*,
                SweepSums*);
  // Adds the impulses kept in the contacts to the velocities (warm start).
  void (*apply_impulses)(const ContactArrays&, std::size_t count, double spin_factor, DiskMotion*);
  // Small steps. One sweep over pairs or walls. `before`: velocities at the start of the small
  // step.
  void (*small_sweep_pairs)(const ContactArrays&, std::size_t count, const ContactTerms&,
                            const SmallStep&, const DiskShift*, DiskMotion*, DiskMotion* before,
                            SmallStepSums*);
  void (*small_sweep_walls)(const ContactArrays&, std::size_t count, const ContactTerms&,
                            const SmallStep&, const DiskShift*, DiskMotion*, DiskMotion* before,
                            SmallStepSums*);
  // Ends the last small step of a step.
  void (*close_pairs)(const ContactArrays&, std::size_t count, const ContactTerms&,
                      const SmallStep&, const DiskShift*, SmallStepSums*, ContactSums*);
  void (*close_walls)(const ContactArrays&, std::size_t count, const ContactTerms&,
                      const SmallStep&, const DiskShift*, SmallStepSums*, ContactSums*);
};

struct Kernels {
  const char* name;
  // Narrow phase: appends the pairs that can act in this step, colour by colour. `ahead`: positions
  // that the velocities lead to by the end of the step, radii with the speculative margin. Returns
  // the padded number of contacts; `contact_count` counts real ones. `touched` gets 1 for their
  // disks. `picked`: scratch as long as the candidates.
  std::size_t (*select_pairs)(const CandidateArrays&, const DiskPose*, const DiskMotion*,
                              const DiskPose* ahead, std::int32_t rest, const ContactTerms&,
                              const ContactArrays&, std::uint8_t* touched, std::int32_t* picked,
                              std::size_t* contact_count);
  // Moves the disks of `index` through a small step h and starts the next one with the same
  // acceleration (gravity and warm start in one). Returns sum m dv^2 / 2 [J], 0 without books.
  double (*advance_disks)(const std::uint32_t* index, std::size_t count, double small_step,
                          bool books, const double* mass, DiskMotion*, DiskMotion* before,
                          DiskShift*);
  ContactKernels combination[kCombinationCount];  // in the order of kContactCombinations

  // Precondition: the table has this combination.
  const ContactKernels& laws(const ContactEffects& effects) const;
};

// The fastest variant that this processor runs.
const Kernels& kernels();

// All variants that this processor runs, for tests of their equality.
std::size_t available_kernels(const Kernels** list, std::size_t capacity);

}  // namespace granary::dda
