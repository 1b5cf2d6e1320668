#include "worker/run/result_builder.h"

#include <cstdio>
#include <ctime>

#include "proto/contract/scene_text.h"

namespace granary::run {
namespace {

v1::Quantity quantity_of(const core::ObservedValue& value) {
  v1::Quantity quantity;
  if (value.value) quantity.set_value(*value.value);
  if (value.error) quantity.set_error(*value.error);
  quantity.set_error_basis(value.error_basis);
  quantity.set_unit(value.unit);
  return quantity;
}

// CPU time for one thread and wall time for more: what a step costs the one who waits for it.
double engine_seconds(const RunCosts& costs, std::uint32_t threads) {
  return threads > 1 ? costs.engine_wall_s : costs.engine_cpu_s;
}

v1::Cost cost_message(const RunCosts& costs, std::uint32_t threads) {
  v1::Cost cost;
  cost.set_wall_s(costs.wall_s);
  cost.set_cpu_s(costs.cpu_s + costs.reused_s);
  cost.set_reused_s(costs.reused_s);
  cost.set_steps(costs.steps);
  cost.set_particle_steps(costs.particle_steps);
  if (costs.particle_steps > 0) {
    const double particle_steps = static_cast<double>(costs.particle_steps);
    cost.set_ns_per_particle_step(1e9 * engine_seconds(costs, threads) / particle_steps);
    cost.set_contacts_per_particle(costs.contacts_per_particle_sum / particle_steps);
  }
  cost.set_threads(threads);
  cost.set_peak_rss_bytes(costs.peak_rss_bytes);
  return cost;
}

v1::Ledger ledger_message(const core::EnergyLedger& ledger) {
  v1::Ledger message;
  for (std::size_t i = 0; i < core::kEnergyChannelCount; ++i) {
    v1::LedgerChannel* channel = message.add_channels();
    channel->set_name(std::string(to_string(core::EnergyChannel(i))));
    channel->set_energy_j(ledger.channels_j[i]);
  }
  message.set_throughput_j(ledger.throughput_j);
  message.set_remainder_j(ledger.remainder_j());
  message.set_remainder_ratio(ledger.remainder_ratio());
  return message;
}

v1::Decision decision_of(const RecoveryNote& note) {
  char value[32];
  std::snprintf(value, sizeof value, "%.12g", note.value);
  v1::Decision decision;
  decision.set_path(note.path);
  decision.set_value(value);
  decision.set_chosen_by("recovery");
  decision.set_evidence(note.evidence);
  return decision;
}

std::string date_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::vector<std::pair<std::string, double>> cost_list(const v1::Cost& cost) {
  return {{"wall_s", cost.wall_s()},
          {"cpu_s", cost.cpu_s()},
          {"reused_s", cost.reused_s()},
          {"steps", static_cast<double>(cost.steps())},
          {"particle_steps", static_cast<double>(cost.particle_steps())},
          {"ns_per_particle_step", cost.ns_per_particle_step()},
          {"contacts_per_particle", cost.contacts_per_particle()},
          {"peak_rss_bytes", static_cast<double>(cost.peak_rss_bytes())}};
}

// The discharge engine has one thread, however many a scene allows.
std::uint32_t threads_of(const v1::Scene& scene) {
  return scene.has_chute() && scene.has_threads() ? scene.threads() : 1;
}

storage::ProvenanceContent provenance_of(const TaskSpec& spec, const v1::Result& message) {
  storage::ProvenanceContent provenance;
  provenance.engine_version = spec.engine_version;
  provenance.vector_path = spec.vector_path;
  provenance.host = spec.host;
  provenance.date_utc = date_utc();
  provenance.scene_key = spec.scene_key;
  provenance.state_hash = message.state_hash();
  provenance.threads = message.cost().threads();
  provenance.costs = cost_list(message.cost());
  for (const v1::Decision& decision : message.decisions())
    provenance.decisions.push_back(
        {decision.path(), decision.value(), decision.chosen_by(), decision.evidence()});
  provenance.warnings.assign(message.warnings().begin(), message.warnings().end());
  return provenance;
}

storage::EffectContent effect_content(const std::string& name, const v1::EffectReport& report) {
  storage::EffectContent effect{name, report.on(), {}, {}, {}, report.reason(), report.chosen_by()};
  if (report.has_number()) effect.number = report.number();
  if (report.has_threshold()) effect.threshold = report.threshold();
  if (report.has_omitted_error()) effect.omitted_error = report.omitted_error();
  return effect;
}

}  // namespace

v1::Result result_message(const TaskSpec& spec, const RunRecord& record, const RunReport& report) {
  v1::Result result;
  result.set_kind(spec.scene.has_chute() ? "chute" : "discharge");
  for (const core::ObservedValue& value : report.values)
    (*result.mutable_values())[value.name] = quantity_of(value);
  *result.mutable_cost() = cost_message(record.costs, threads_of(spec.scene));
  *result.mutable_ledger() = ledger_message(report.ledger);
  for (const auto& [name, effect] : spec.effects) (*result.mutable_effects())[name] = effect;
  result.set_engine_version(spec.engine_version);
  result.set_state_hash(report.state_hash);
  result.mutable_decisions()->Assign(spec.decisions.begin(), spec.decisions.end());
  for (const RecoveryNote& note : record.notes) *result.add_decisions() = decision_of(note);
  for (const std::string& warning : spec.warnings) result.add_warnings(warning);
  for (const std::string& warning : report.warnings) result.add_warnings(warning);
  result.set_host(spec.host);
  return result;
}

storage::ResultContent result_content(const TaskSpec& spec, const RunRecord& record,
                                      const RunReport& report, const v1::Result& message) {
  storage::ResultContent content;
  content.kind = message.kind();
  content.state = report.state;
  content.message = report.message;
  content.scene_text = scene_to_text(spec.scene);
  content.observation = record.first;
  content.observation.values = report.values;
  if (record.finished.size() > 1)
    for (const FinishedReplicate& replicate : record.finished)
      content.replicates.push_back({replicate.seed, replicate.state_hash, replicate.values});
  content.ledger = report.ledger;
  for (const auto& [name, effect] : spec.effects)
    content.effects.push_back(effect_content(name, effect));
  content.provenance = provenance_of(spec, message);
  return content;
}

}  // namespace granary::run
