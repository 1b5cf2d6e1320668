#include "worker/run/recovery.h"

#include <algorithm>
#include <cstdio>

namespace granary::run {
namespace {

using core::Cause;
using core::Remedy;

// In the order they are tried. Bodies that overlap without moving fast are too soft, so the penalty
// is raised where it is a numerical setting; a stiffness that belongs to the material is left to
// the user.
std::span<const Remedy> remedies_of(Cause cause) {
  static constexpr Remedy kStep[] = {Remedy::halve_time_step, Remedy::halve_time_step,
                                     Remedy::halve_time_step, Remedy::halve_time_step};
  static constexpr Remedy kOverlap[] = {Remedy::halve_time_step, Remedy::tighten_tolerance,
                                        Remedy::raise_penalty, Remedy::raise_penalty};
  static constexpr Remedy kTwice[] = {Remedy::halve_time_step, Remedy::halve_time_step};
  static constexpr Remedy kEnergy[] = {Remedy::tighten_tolerance, Remedy::halve_time_step,
                                       Remedy::halve_time_step, Remedy::halve_time_step,
                                       Remedy::halve_time_step};
  switch (cause) {
    case Cause::overlap:
      return kOverlap;
    case Cause::speed:
    case Cause::not_converged:
      return kStep;
    case Cause::not_finite:
      return kTwice;
    case Cause::energy:
      return kEnergy;
    case Cause::other:
      break;
  }
  return {};
}

const char* deed(Remedy remedy) {
  switch (remedy) {
    case Remedy::halve_time_step:
      return "halved it";
    case Remedy::tighten_tolerance:
      return "divided it by ten";
    case Remedy::raise_penalty:
      return "multiplied it by ten";
  }
  return "";
}

}  // namespace

std::optional<Remedy> next_remedy(Cause cause, std::span<const Recovery> before,
                                  const core::Simulation& simulation) {
  if (before.size() >= kMostRecoveries) return std::nullopt;
  std::vector<Remedy> left;
  for (const Remedy remedy : remedies_of(cause))
    if (simulation.knows(remedy)) left.push_back(remedy);
  const auto tried = static_cast<std::size_t>(
      std::count_if(before.begin(), before.end(),
                    [&](const Recovery& recovery) { return recovery.cause == cause; }));
  return tried < left.size() ? std::optional(left[tried]) : std::nullopt;
}

bool starts_over(Remedy remedy) {
  return remedy == Remedy::raise_penalty;
}

std::vector<Remedy> active_remedies(std::span<const Recovery> recoveries) {
  std::vector<Remedy> active;
  for (const Recovery& recovery : recoveries) {
    if (starts_over(recovery.remedy))
      std::erase_if(active, [](Remedy remedy) { return !starts_over(remedy); });
    active.push_back(recovery.remedy);
  }
  return active;
}

RecoveryNote note_of(const core::Rejection& rejection, const core::SettingChange& change,
                     Remedy remedy, double back_to_s) {
  char where[64];
  if (starts_over(remedy))
    std::snprintf(where, sizeof where, "started over");
  else
    std::snprintf(where, sizeof where, "went back to t = %.6g s", back_to_s);
  char from[48];
  std::snprintf(from, sizeof from, " (from %.6g)", change.before);
  return {change.path, change.after,
          rejection.reason + ": " + where + " and " + deed(remedy) + from};
}

}  // namespace granary::run
