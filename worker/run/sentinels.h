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

struct NonFinite {
  std::string column;
  std::int64_t row = 0;
};
std::optional<NonFinite> find_non_finite(std::span<const core::ColumnView> columns);

core::Rejection rejection_of(const NonFinite& where, double time_s);

// A value or error that is no number becomes unknown, with the reason; returns a warning for each.
std::vector<std::string> withhold_non_finite(std::vector<core::ObservedValue>& values);

// One line for people: when, why, who, what to change.
std::string describe(const core::Rejection& rejection);

}  // namespace granary::run
