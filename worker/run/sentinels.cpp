#include "worker/run/sentinels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace granary::run {
namespace {

template <typename T>
std::optional<std::size_t> first_non_finite(const core::ColumnView& column) {
  const std::span values(static_cast<const T*>(column.data), column.rows * column.width);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) return i;
  return std::nullopt;
}

std::optional<std::size_t> first_non_finite_of(const core::ColumnView& column) {
  if (column.type == core::ElementType::f64) return first_non_finite<double>(column);
  if (column.type == core::ElementType::f32) return first_non_finite<float>(column);
  return std::nullopt;
}

bool is_unusable(const std::optional<double>& number) {
  return number && !std::isfinite(*number);
}

}  // namespace

bool ledger_is_finite(const core::EnergyLedger& ledger) {
  return std::isfinite(ledger.stored_j()) && std::isfinite(ledger.remainder_j()) &&
         std::isfinite(ledger.throughput_j);
}

std::optional<NonFinite> find_non_finite(std::span<const core::ColumnView> columns) {
  for (const core::ColumnView& column : columns)
    if (const auto element = first_non_finite_of(column))
      return NonFinite{std::string(column.name),
                       static_cast<std::int64_t>(*element / column.width)};
  return std::nullopt;
}

core::Rejection rejection_of(const NonFinite& where, double time_s) {
  return {time_s, where.column + " is not finite", {where.row}, "", core::Cause::not_finite};
}

std::optional<core::Rejection> energy_rejection(const core::EnergyLedger& ledger, double time_s) {
  const double stored = std::abs(ledger.kinetic_j) + std::abs(ledger.potential_j) +
                        std::abs(ledger.elastic_j) + std::abs(ledger.stored_at_start_j);
  const auto exceeds = [&](double energy, double share) {
    return energy > share * ledger.throughput_j && energy > kRemainderRounding * stored;
  };
  const double integrator = ledger[core::EnergyChannel::integrator];
  const double dissipated = integrator + ledger[core::EnergyChannel::normal_damping] +
                            ledger[core::EnergyChannel::friction] +
                            ledger[core::EnergyChannel::rolling];
  const double missing = std::abs(ledger.remainder_j());
  const double added = -std::min(integrator, dissipated);
  char text[112];
  if (exceeds(missing, kWrongRemainder)) {
    std::snprintf(text, sizeof text, "%.2g of the energy exchanged is missing from the ledger",
                  ledger.remainder_ratio());
  } else if (exceeds(added, kLargestGain)) {
    std::snprintf(text, sizeof text, "%s added %.2g of the energy exchanged",
                  integrator < dissipated ? "the integrator" : "contacts that only dissipate",
                  added / ledger.throughput_j);
  } else {
    return std::nullopt;
  }
  return core::Rejection{time_s, text, {}, "", core::Cause::energy};
}

std::optional<core::Rejection> convergence_rejection(std::uint64_t unconverged, std::uint64_t steps,
                                                     double time_s) {
  if (static_cast<double>(unconverged) <= kLargestUnconvergedShare * static_cast<double>(steps))
    return std::nullopt;
  char text[96];
  std::snprintf(text, sizeof text, "the contact solver did not settle in %llu of %llu steps",
                static_cast<unsigned long long>(unconverged),
                static_cast<unsigned long long>(steps));
  return core::Rejection{time_s,
                         text,
                         {},
                         "discharge.solver.method IMPULSE, or a smaller discharge.time_step_s",
                         core::Cause::not_converged};
}

std::vector<std::string> withhold_non_finite(std::vector<core::ObservedValue>& values) {
  std::vector<std::string> warnings;
  for (core::ObservedValue& value : values) {
    if (is_unusable(value.value)) {
      value.value.reset();
      value.error.reset();
      value.error_basis = "withheld: not a finite number";
      warnings.push_back(value.name + " is not a finite number and was withheld");
    } else if (is_unusable(value.error)) {
      value.error.reset();
      value.error_basis = "error withheld: not a finite number";
      warnings.push_back("error of " + value.name + " is not a finite number and was withheld");
    }
  }
  return warnings;
}

std::string describe(const core::Rejection& rejection) {
  char time[40];
  std::snprintf(time, sizeof time, "unstable at t = %.6g s: ", rejection.time_s);
  std::string text = time + rejection.reason;
  constexpr std::size_t kMaxIds = 5;
  for (std::size_t i = 0; i < rejection.ids.size() && i < kMaxIds; ++i)
    text += (i == 0 ? " (particle " : ", ") + std::to_string(rejection.ids[i]);
  if (rejection.ids.size() > kMaxIds) text += ", ...";
  if (!rejection.ids.empty()) text += ")";
  if (!rejection.suggestion.empty()) text += "; try: " + rejection.suggestion;
  return text;
}

}  // namespace granary::run
