// What a result file holds besides its frames, as plain data: storage knows no scenes and no
// physics.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "worker/core/energy_ledger.h"
#include "worker/core/simulation.h"

namespace granary::storage {

struct EffectContent {
  std::string name;
  bool on = false;
  std::optional<double> number;  // dimensionless, decides on/off
  std::optional<double> threshold;
  std::optional<double> omitted_error;  // relative
  std::string reason;
  std::string chosen_by;
};

struct DecisionContent {
  std::string path;
  std::string value;
  std::string chosen_by;  // "user", "default" or "auto"
  std::string evidence;
};

struct ReplicateContent {
  std::uint64_t seed = 0;
  std::string state_hash;
  std::vector<core::ObservedValue> values;
};

struct ProvenanceContent {
  std::string engine_version;
  std::string vector_path;
  std::string host;
  std::string date_utc;  // ISO 8601, end of the run
  std::string scene_key;
  std::string state_hash;
  std::uint32_t threads = 1;
  // Numbers with their unit in the name: "wall_s", "cpu_s", "steps", ...
  std::vector<std::pair<std::string, double>> costs;
  std::vector<DecisionContent> decisions;
  std::vector<std::string> warnings;
};

struct ResultContent {
  std::string kind;        // "discharge" or "chute"
  std::string state;       // "complete", "unstable" or "partial"
  std::string message;     // why it is not complete
  std::string scene_text;  // resolved scene, protobuf text format
  core::Observation observation;
  std::vector<ReplicateContent> replicates;  // empty for a single run
  std::optional<core::EnergyLedger> ledger;  // unknown for partial results
  std::vector<EffectContent> effects;
  ProvenanceContent provenance;
};

}  // namespace granary::storage
