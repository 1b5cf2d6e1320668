// Everything a time step works on: disks, walls and their motion, contact lists, ledger.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "worker/core/energy_ledger.h"
#include "worker/dda/belt_drive.h"
#include "worker/dda/contact_effects.h"
#include "worker/dda/contact_list.h"
#include "worker/dda/disks.h"
#include "worker/dda/kernels.h"
#include "worker/dda/neighbour_lists.h"
#include "worker/dda/walls.h"

namespace granary::dda {

struct ContactSettings {
  double stiffness = 1e7;     // K_N = K_T [N/m] for the whole axial depth
  double friction_disks = 0;  // tan of the friction angle inside the material
  double friction_walls = 0;
  double restitution = 0;       // Newton, normal
  double rolling_friction = 0;  // mu_r: torque <= mu_r r P_n
  double cohesion = 0;          // F_c [N] for the whole axial depth
  ContactEffects effects;       // the laws of the kernels that run; a law that is off is not read
};

enum class SolverMethod : std::uint8_t {
  impulse,    // dual form, projected Gauss-Seidel
  open_close  // assembled penalty matrix, open-close iteration
};

enum class Integrator : std::uint8_t { backward_euler, newmark_dda, newmark_trapezoid };

enum class LinearSolver : std::uint8_t { direct, pcg };  // of open_close

struct SolverSettings {
  SolverMethod method = SolverMethod::impulse;
  Integrator integrator = Integrator::backward_euler;
  LinearSolver linear = LinearSolver::direct;
  double tolerance = 1e-2;         // |change of impulses| / |impulses| that ends the sweeps
  std::uint32_t max_sweeps = 500;  // or open-close iterations
  double relaxation = 1.3;         // typical 1..1.5; 2 diverges
  double margin_ratio = 0.1;       // speculative contacts: gap < margin_ratio (r_i + r_k)
  double skin_ratio = 1.2;         // neighbour lists: skin / mean radius
  // Steps are cut into small ones with K h^2 / m at most this; 0 = one solve per step.
  // Only the impulse solver with backward Euler knows them.
  double small_step_kappa = 1;
};

// The paper's sequential increase of the penalty (section 4.1).
struct PenaltyGrowth {
  double factor = 1;        // per step that needs it; 1 = the penalty stays
  double tolerance = 0.01;  // overlap / radius of the smaller disk
};

enum class StepPhase : std::size_t { lists, contacts, sweeps, integration, ledger, count };
constexpr std::size_t kStepPhaseCount = static_cast<std::size_t>(StepPhase::count);
std::string_view to_string(StepPhase phase);

struct StepCounters {
  std::uint64_t steps = 0;
  std::uint64_t disk_steps = 0;
  std::uint64_t sweeps = 0;
  std::uint64_t contact_updates = 0;
  std::uint64_t unconverged_steps = 0;  // stopped by max_sweeps
  std::uint64_t open_close_iterations = 0;
  std::uint64_t linear_iterations = 0;  // of PCG
  std::uint64_t penalty_growths = 0;
  std::uint64_t drag_evaluations = 0;  // 0 proves that the air is off
  EffectCounts effects;
};

// What the last step saw.
struct StepReport {
  std::size_t contacts = 0;
  std::uint32_t sweeps = 0;  // or open-close iterations
  bool converged = true;
  double worst_overlap = 0;   // m, at the start of the step
  double kinetic_energy = 0;  // J, of disks that have not landed
};

// Of the contact forces on one disk at the end of a step.
struct DiskAcceleration {
  double x = 0, y = 0;  // m/s2
  double surface = 0;   // of the surface speed
};

struct System {
  ContactSettings contact;
  SolverSettings solver;
  PenaltyGrowth penalty;
  double gravity = 9.81;
  double damping_rate = 0;  // 1/s, C = rate M of the paper's Eq. 3
  double time_step = 2e-4;

  Disks disks;
  Walls walls;
  BeltDrive drive;
  bool belt_runs = false;  // false: the bucket rests at theta = 0
  double time = 0;

  NeighbourLists lists;
  ActiveContacts pair_contacts;
  ActiveContacts wall_contacts;
  std::vector<Vec2> wall_velocity;    // of wall_contacts: at the touching point
  std::vector<std::uint8_t> touched;  // per disk (+1): has an active contact in this step
  AlignedVector<DiskMotion> motion_before;
  std::vector<DiskAcceleration> contact_acceleration;  // newmark_trapezoid; empty = not known yet

  // Scratch of a step.
  AlignedVector<DiskPose> ahead;  // where the velocities lead, radius with the speculative margin
  AlignedVector<DiskShift> shift;
  std::vector<std::int32_t> picked;
  std::vector<std::uint32_t> touched_index;
  SmallStepSums pair_sums, wall_sums;
  double kinetic_dissipation = 0;  // J, of the small steps: sum m dv^2 / 2

  // Derived from the disks by note_masses().
  std::vector<double> mass;  // kg
  double mean_mass = 0;
  double mean_radius = 0, smallest_radius = 0;
  double lightest = 0;    // kg
  bool one_mass = false;  // all disks have the same

  core::EnergyLedger ledger;
  bool ledger_is_new = true;  // overlaps at its start are only seen in its first step
  bool keeps_books = true;    // false while nothing drives the disks: lower_ledger_start()
  StepCounters counters;
  StepReport report;
  std::array<double, kStepPhaseCount> phase_seconds{};

  RigidPose bucket_pose(double at_time) const {
    return belt_runs ? drive.pose_at(at_time) : RigidPose{};
  }
  RigidVelocity bucket_velocity() const {
    return belt_runs ? drive.velocity_at(time) : RigidVelocity{};
  }
};

// After the disks were replaced: forgets every contact, sizes the lists, restarts the ledger.
void reset_contacts(System& system);
double mean_radius(const Disks& disks);
void note_masses(System& system);

}  // namespace granary::dda
