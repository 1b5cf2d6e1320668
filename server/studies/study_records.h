// Plain records of studies and trials, as policy sees them and the store keeps them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "granary/v1/study.pb.h"
#include "server/jobs/records.h"

namespace granary::server {

struct StudyRecord {
  StudyId id = 0;
  std::string kind;
  std::string name;
  v1::Study::State state = v1::Study::RUNNING;
  std::string owner;
  std::string request_id;
  std::string spec_bytes;       // v1.StudySpec; empty in lists
  std::string generator_bytes;  // StudyGenerator::save(); empty in lists
  std::int64_t submitted_ms = 0;
  std::int64_t ended_ms = 0;
  std::uint32_t planned = 0;
  std::uint32_t trials = 0;  // proposed
  std::uint32_t told = 0;    // ended and heard by the generator, in order
  std::uint32_t failed = 0;
  std::uint32_t reused = 0;
  std::string message;
  v1::StudySummary summary;
};

struct TrialRecord {
  StudyId study = 0;
  std::uint32_t number = 0;
  JobId job = 0;  // 0 = the scene was refused
  std::string label;
  std::string role;
  std::uint32_t candidate = 0;
  std::string inputs;  // JSON object: scene path -> value as text
  std::string error;   // why there is no job
  bool told = false;
  std::optional<double> objective;
  std::optional<double> objective_error;
  std::optional<bool> feasible;
  std::optional<double> best_objective;  // best feasible one up to here
  bool pareto = false;
};

}  // namespace granary::server
