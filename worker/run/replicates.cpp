#include "worker/run/replicates.h"

#include <algorithm>

#include "worker/core/column.h"
#include "worker/core/random.h"
#include "worker/core/student_t.h"

namespace granary::run {
namespace {

const core::ObservedValue* find_value(const FinishedReplicate& replicate, const std::string& name) {
  for (const core::ObservedValue& value : replicate.values)
    if (value.name == name) return &value;
  return nullptr;
}

core::ObservedValue combine_value(const core::ObservedValue& first,
                                  const std::vector<FinishedReplicate>& replicates) {
  std::vector<double> samples;
  for (const FinishedReplicate& replicate : replicates) {
    const core::ObservedValue* value = find_value(replicate, first.name);
    if (value != nullptr && value->value) samples.push_back(*value->value);
  }
  const std::string count = std::to_string(replicates.size());
  core::ObservedValue combined{first.name, first.unit, {}, {}, ""};
  if (samples.size() < replicates.size()) {
    combined.error_basis =
        "known in " + std::to_string(samples.size()) + " of " + count + " replicates";
    return combined;
  }
  const auto interval = core::mean_with_interval(samples);
  combined.value = interval->mean;
  combined.error = interval->half_width;
  combined.error_basis = "95 % t-interval of " + count + " replicates";
  return combined;
}

}  // namespace

std::uint64_t replicate_seed(std::uint64_t scene_seed, std::uint32_t replicate) {
  constexpr std::uint64_t kReplicateStream = 0x7265706c69636174;  // "replicat"
  return replicate == 0 ? scene_seed : core::random_bits(scene_seed, kReplicateStream, replicate);
}

std::vector<core::ObservedValue> combine_values(const std::vector<FinishedReplicate>& replicates) {
  std::vector<core::ObservedValue> values;
  for (const core::ObservedValue& first : replicates.front().values) {
    if (replicates.size() > 1) {
      values.push_back(combine_value(first, replicates));
      continue;
    }
    values.push_back(first);
    if (!first.error && first.error_basis.empty())
      values.back().error_basis = "single run: set replicates";
  }
  return values;
}

std::string combine_state_hashes(const std::vector<FinishedReplicate>& replicates) {
  if (replicates.size() == 1) return replicates.front().state_hash;
  std::string all;
  for (const FinishedReplicate& replicate : replicates) all += replicate.state_hash;
  const core::ColumnView view{"state_hashes", "1", core::ElementType::u8,
                              all.size(),     1,   all.data()};
  return core::hash_columns(std::span(&view, 1));
}

const core::EnergyLedger& worst_ledger(const std::vector<FinishedReplicate>& replicates) {
  return std::max_element(replicates.begin(), replicates.end(),
                          [](const FinishedReplicate& a, const FinishedReplicate& b) {
                            return a.ledger.remainder_ratio() < b.ledger.remainder_ratio();
                          })
      ->ledger;
}

}  // namespace granary::run
