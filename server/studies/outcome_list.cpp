#include "server/studies/outcome_list.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <stdexcept>

namespace granary::server {
namespace {

// Beside the values of a saved trial.
constexpr const char* kMemory = "peak_rss_bytes";
constexpr const char* kRemainder = "ledger_remainder_ratio";

v1::Trial message_of(const ShortOutcome& outcome) {
  v1::Trial trial;
  trial.set_job(outcome.job);
  trial.set_state(outcome.complete ? v1::COMPLETE : v1::ERROR);
  trial.set_error(outcome.error);
  trial.set_cpu_s(outcome.cpu_s);
  for (const auto& [name, value] : outcome.values) {
    v1::Quantity& quantity = (*trial.mutable_values())[name];
    if (value.value) quantity.set_value(*value.value);
    if (value.error) quantity.set_error(*value.error);
  }
  (*trial.mutable_values())[kMemory].set_value(outcome.peak_rss_bytes);
  (*trial.mutable_values())[kRemainder].set_value(outcome.ledger_remainder_ratio);
  return trial;
}

ShortOutcome outcome_of(const v1::Trial& trial) {
  ShortOutcome outcome;
  outcome.complete = trial.state() == v1::COMPLETE;
  outcome.job = trial.job();
  outcome.error = trial.error();
  outcome.cpu_s = trial.cpu_s();
  for (const auto& [name, quantity] : trial.values()) {
    if (name == kMemory) {
      outcome.peak_rss_bytes = quantity.value();
      continue;
    }
    if (name == kRemainder) {
      outcome.ledger_remainder_ratio = quantity.value();
      continue;
    }
    ShortOutcome::Value& value = outcome.values[name];
    if (quantity.has_value()) value.value = quantity.value();
    if (quantity.has_error()) value.error = quantity.error();
  }
  return outcome;
}

}  // namespace

void OutcomeList::add(const TrialOutcome& outcome) {
  ShortOutcome kept;
  kept.complete = outcome.state == v1::COMPLETE;
  kept.job = outcome.job;
  kept.error = outcome.error;
  kept.cpu_s = outcome.result.cost().cpu_s();
  kept.peak_rss_bytes = static_cast<double>(outcome.result.cost().peak_rss_bytes());
  kept.ledger_remainder_ratio = outcome.result.ledger().remainder_ratio();
  for (const auto& [name, quantity] : outcome.result.values()) {
    ShortOutcome::Value& value = kept.values[name];
    if (quantity.has_value()) value.value = quantity.value();
    if (quantity.has_error()) value.error = quantity.error();
  }
  outcomes_.push_back(std::move(kept));
}

namespace {

// Maps in the order of their keys, so that equal states are equal bytes.
std::string deterministic_bytes(const v1::Trial& trial) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  trial.SerializeToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

}  // namespace

std::string OutcomeList::save() const {
  std::string bytes;
  for (const ShortOutcome& outcome : outcomes_) {
    const std::string one = deterministic_bytes(message_of(outcome));
    bytes += std::to_string(one.size()) + "\n" + one;
  }
  return bytes;
}

void OutcomeList::restore(const std::string& bytes) {
  outcomes_.clear();
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string::npos) throw std::runtime_error("study: outcomes are cut off");
    const std::size_t size = std::stoul(bytes.substr(at, end - at));
    v1::Trial trial;
    if (end + 1 + size > bytes.size() || !trial.ParseFromString(bytes.substr(end + 1, size)))
      throw std::runtime_error("study: outcomes are damaged");
    outcomes_.push_back(outcome_of(trial));
    at = end + 1 + size;
  }
}

std::vector<std::string> main_observables(const v1::Scene& scene) {
  if (scene.has_chute()) return {"exit_speed_m_per_s", "particle_count", "mass_flow_kg_per_s"};
  return {"f1_m", "f2_m", "f3_percent", "f4_m"};
}

}  // namespace granary::server
