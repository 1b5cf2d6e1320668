// Sentinels of the run layer, on top of the engines' own: no NaN and no infinity leaves as a
// result.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "worker/core/column.h"
#include "worker/core/simulation.h"

namespace granary::run {

// Cheap enough for every chunk: a NaN in any velocity or position reaches the stored energies.
bool ledger_is_finite(const core::EnergyLedger& ledger);

// More of the energy exchanged than this may not be missing from the ledger: above the first a
// warning, above the second the run is not to be trusted.
constexpr double kSuspectRemainder = 1e-3;
constexpr double kWrongRemainder = 5e-3;
// Remainders below this share of all stored energy are rounding.
constexpr double kRemainderRounding = 1e-9;

// Integrator, dampers and friction may dissipate; where they add more than this share of the energy
// exchanged, the step has left its range of stability.
constexpr double kLargestGain = 0.05;

// Of the steps since the last mark, this many may stop short of the solver's tolerance.
constexpr double kLargestUnconvergedShare = 0.25;

std::optional<core::Rejection> energy_rejection(const core::EnergyLedger& ledger, double time_s);
std::optional<core::Rejection> convergence_rejection(std::uint64_t unconverged, std::uint64_t steps,
                                                     double time_s);

struct NonFinite {
  std::string column;
  std::int64_t row = 0;
};
std::optional<NonFinite> find_non_finite(std::span<const core::ColumnView> columns);

// The run layer's own rejections leave the suggestion empty: a smaller time step of the scene.
core::Rejection rejection_of(const NonFinite& where, double time_s);

// A value or error that is no number becomes unknown, with the reason; returns a warning for each.
std::vector<std::string> withhold_non_finite(std::vector<core::ObservedValue>& values);

// One line for people: when, why, who, what to change.
std::string describe(const core::Rejection& rejection);

}  // namespace granary::run
