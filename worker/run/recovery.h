// What a run does when a sentinel trips: it goes back to its last mark - a state that was checked
// in full - and changes one numerical setting, chosen by the cause, for the rest of the replicate.
// Marks lie at step numbers fixed by the scene, so that recovery is as reproducible as the run.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "worker/core/simulation.h"
#include "worker/run/frame_schedule.h"

namespace granary::run {

constexpr std::size_t kMostRecoveries = 5;  // of one replicate; then it is unstable

// A state worth going back to, without the engine's snapshot.
struct Mark {
  std::uint64_t steps = 0;
  std::uint64_t unconverged_steps = 0;
  double time_s = 0;
  double contacts_per_particle_sum = 0;  // RunCosts at that moment
  FrameSchedule::State frames;
};

struct Recovery {
  core::Cause cause = core::Cause::other;
  core::Remedy remedy = core::Remedy::halve_time_step;
};

// What the user is told of one recovery: a decision of the run.
struct RecoveryNote {
  std::string path;
  double value = 0;
  std::string evidence;
};

// The setting to change next, or nothing when no remedy of this cause is left to try.
std::optional<core::Remedy> next_remedy(core::Cause cause, std::span<const Recovery> before,
                                        const core::Simulation& simulation);

// A run that starts over does so with the raised penalty alone.
bool starts_over(core::Remedy remedy);
std::vector<core::Remedy> active_remedies(std::span<const Recovery> recoveries);

RecoveryNote note_of(const core::Rejection& rejection, const core::SettingChange& change,
                     core::Remedy remedy, double back_to_s);

}  // namespace granary::run
