// Independent repetitions of one scene: their seeds, and one value with an error bar out of many.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/core/energy_ledger.h"
#include "worker/core/simulation.h"

namespace granary::run {

struct FinishedReplicate {
  std::uint64_t seed = 0;
  std::string state_hash;
  std::vector<core::ObservedValue> values;
  core::EnergyLedger ledger;
};

// Replicate 0 runs with the scene's own seed, so that it is the run without replicates.
std::uint64_t replicate_seed(std::uint64_t scene_seed, std::uint32_t replicate);

// One replicate: its values as they are, with the reason why an error is missing. Several: the mean
// and the half-width of its 95 % t-interval; a value unknown in any of them stays unknown, because
// the rest would be a biased sample.
std::vector<core::ObservedValue> combine_values(const std::vector<FinishedReplicate>& replicates);

// One replicate: its hash. Several: the hash over all of theirs, in order.
std::string combine_state_hashes(const std::vector<FinishedReplicate>& replicates);

// The ledger that closes worst: an average would hide it.
const core::EnergyLedger& worst_ledger(const std::vector<FinishedReplicate>& replicates);

}  // namespace granary::run
