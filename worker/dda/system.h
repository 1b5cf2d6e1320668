// Everything a time step works on: disks, walls and their motion, contact lists, ledger.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "worker/core/energy_ledger.h"
#include "worker/dda/belt_drive.h"
#include "worker/dda/contact_list.h"
#include "worker/dda/disks.h"
#include "worker/dda/neighbour_lists.h"
#include "worker/dda/walls.h"

namespace granary::dda {

struct ContactSettings {
  double stiffness = 1e7;     // K_N = K_T [N/m] for the whole axial depth
  double friction_disks = 0;  // tan of the friction angle inside the material
  double friction_walls = 0;
  double restitution = 0;  // Newton, normal
  bool rotation = true;    // false: disks never spin
};

struct SolverSettings {
  double tolerance = 1e-2;  // |change of impulses| / |impulses| that ends the sweeps
  std::uint32_t max_sweeps = 500;
  double relaxation = 1.3;     // typical 1..1.5; 2 diverges
  double margin_ratio = 0.15;  // speculative contacts: gap < margin_ratio (r_i + r_k)
  double skin_ratio = 0.8;     // neighbour lists: skin / mean radius
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
};

// What the last step saw.
struct StepReport {
  std::size_t contacts = 0;
  std::uint32_t sweeps = 0;
  double worst_overlap = 0;   // m, at the start of the step
  double kinetic_energy = 0;  // J, of disks that have not landed
};

struct System {
  ContactSettings contact;
  SolverSettings solver;
  double gravity = 9.81;
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

  core::EnergyLedger ledger;
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

}  // namespace granary::dda
