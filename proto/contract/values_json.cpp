#include "proto/contract/values_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "proto/contract/job_state.h"

namespace granary {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(bool there, double value) {
  return there && std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json values_of(const v1::Result& result) {
  Json out = Json::object();
  std::map<std::string, v1::Quantity> sorted(result.values().begin(), result.values().end());
  for (const auto& [name, quantity] : sorted) {
    Json entry;
    entry["value"] = number_or_null(quantity.has_value(), quantity.value());
    entry["error"] = number_or_null(quantity.has_error(), quantity.error());
    if (!quantity.error_basis().empty()) entry["error_basis"] = quantity.error_basis();
    out[name] = entry;
  }
  return out;
}

Json cost_of(const v1::Cost& cost) {
  return {{"wall_s", cost.wall_s()},
          {"cpu_s", cost.cpu_s()},
          {"steps", cost.steps()},
          {"particle_steps", cost.particle_steps()},
          {"ns_per_particle_step", cost.ns_per_particle_step()},
          {"contacts_per_particle", cost.contacts_per_particle()},
          {"threads", cost.threads()},
          {"peak_rss_bytes", cost.peak_rss_bytes()},
          {"reused_s", cost.reused_s()}};
}

Json effects_of(const v1::Result& result) {
  Json out = Json::object();
  std::map<std::string, v1::EffectReport> sorted(result.effects().begin(), result.effects().end());
  for (const auto& [name, effect] : sorted) {
    out[name] = {
        {"on", effect.on()},
        {"number", number_or_null(effect.has_number(), effect.number())},
        {"threshold", number_or_null(effect.has_threshold(), effect.threshold())},
        {"omitted_error", number_or_null(effect.has_omitted_error(), effect.omitted_error())},
        {"chosen_by", effect.chosen_by()},
        {"reason", effect.reason()}};
  }
  return out;
}

}  // namespace

std::string values_json(const v1::GetValuesResponse& response) {
  Json out;
  out["job"] = response.name();
  out["kind"] = response.kind();
  out["state"] = to_string(response.state());
  const v1::Result& result = response.result();
  out["values"] = values_of(result);
  out["cost"] = cost_of(result.cost());
  out["ledger"] = {
      {"remainder_ratio", number_or_null(result.has_ledger(), result.ledger().remainder_ratio())}};
  out["effects"] = effects_of(result);
  out["engine_version"] = result.engine_version();
  out["state_hash"] = result.state_hash();
  if (result.warnings_size() > 0)
    out["warnings"] = std::vector<std::string>(result.warnings().begin(), result.warnings().end());
  if (!response.error().empty()) out["error"] = response.error();
  return out.dump();
}

}  // namespace granary
