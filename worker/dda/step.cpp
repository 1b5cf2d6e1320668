#include "worker/dda/step.h"

#include <chrono>

#include "worker/dda/impulse_solver.h"
#include "worker/dda/narrow_phase.h"
#include "worker/dda/step_energy.h"

namespace granary::dda {
namespace {

// Adds the seconds since the last lap to a phase.
class PhaseClock {
 public:
  explicit PhaseClock(System& system) : system_(system) {}
  void lap(StepPhase phase) {
    const auto now = Clock::now();
    system_.phase_seconds[static_cast<std::size_t>(phase)] +=
        std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  System& system_;
  Clock::time_point last_ = Clock::now();
};

void refresh_lists(System& system) {
  if (!system.lists.stale()) return;
  system.lists.rebuild(system.disks, system.touched, system.walls,
                       {system.bucket_velocity(), system.bucket_pose(system.time), system.gravity,
                        system.time_step});
}

void finish_step(System& system) {
  system.time += system.time_step;
  system.lists.note_step(system.disks, system.time_step);
  ++system.counters.steps;
  system.counters.disk_steps += system.disks.count();
}

}  // namespace

void step(System& system) {
  PhaseClock clock(system);
  refresh_lists(system);
  clock.lap(StepPhase::lists);
  system.motion_before = system.disks.motion;
  select_contacts(system);
  clock.lap(StepPhase::contacts);
  solve_impulses(system);
  keep_forces(system);
  clock.lap(StepPhase::sweeps);
  book_contacts(system);
  clock.lap(StepPhase::ledger);
  integrate(system);
  clock.lap(StepPhase::integration);
  finish_step(system);
  clock.lap(StepPhase::lists);
}

}  // namespace granary::dda
