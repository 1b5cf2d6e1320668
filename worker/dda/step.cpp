#include "worker/dda/step.h"

#include <chrono>

#include "worker/dda/impulse_solver.h"
#include "worker/dda/integrators.h"
#include "worker/dda/mass_damping.h"
#include "worker/dda/narrow_phase.h"
#include "worker/dda/open_close.h"
#include "worker/dda/penalty_growth.h"
#include "worker/dda/small_steps.h"
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
  system.lists.refresh(
      system.disks, system.walls,
      {system.bucket_pose(system.time), system.bucket_pose(system.time + system.time_step),
       system.time_step, system.solver.margin_ratio});
}

void solve_contacts(System& system) {
  if (system.solver.method == SolverMethod::open_close)
    solve_open_close(system);
  else
    solve_impulses(system);
}

void finish_step(System& system) {
  system.time += system.time_step;
  ++system.counters.steps;
  system.counters.disk_steps += system.disks.count();
}

void one_solve(System& system, PhaseClock& clock) {
  add_loads(system);
  solve_contacts(system);
  keep_forces(system);
  keep_contact_accelerations(system);
  clock.lap(StepPhase::sweeps);
  book_contacts(system);
  clock.lap(StepPhase::ledger);
  integrate(system);
  clock.lap(StepPhase::integration);
}

void small_steps(System& system, PhaseClock& clock) {
  solve_small_steps(system);
  clock.lap(StepPhase::sweeps);
  close_small_steps(system);
  clock.lap(StepPhase::ledger);
  keep_forces(system);
  integrate_small_steps(system);
  clock.lap(StepPhase::integration);
}

}  // namespace

void step(System& system) {
  PhaseClock clock(system);
  const double remainder = system.ledger.remainder_j();
  refresh_lists(system);
  clock.lap(StepPhase::lists);
  begin_integration(system);
  select_contacts(system);
  clock.lap(StepPhase::contacts);
  if (takes_small_steps(system))
    small_steps(system, clock);
  else
    one_solve(system, clock);
  if (system.damping_rate > 0) damp_disks(system);
  grow_penalty(system);
  if (!system.keeps_books) lower_ledger_start(system, remainder);
  finish_step(system);
}

}  // namespace granary::dda
