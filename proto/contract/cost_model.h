// What a scene will cost before it runs: CPU seconds, memory, disk, each with an interval. The work
// is counted from the scene (particle steps of every phase), its price per particle step is that of
// the engines on a Zen 4 core, corrected by what this host's runs have cost (calibration.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "granary/v1/scene.pb.h"
#include "proto/contract/calibration.h"

namespace granary {

struct Estimate {
  double value = 0;
  double low = 0, high = 0;  // 95 % interval
};

struct CostEstimate {
  Estimate cpu_s;
  Estimate memory_bytes;  // peak of the process
  Estimate disk_bytes;    // result file; twice that while it is assembled
  double steps = 0;
  double particle_steps = 0;
  std::uint64_t particles = 0;  // grains that will ever be in the scene
  double ns_per_particle_step = 0;
  std::string engine;  // key of the calibration: "discharge", "discharge/open_close", "chute", ...
  std::string basis;   // where price and interval come from
};

// Precondition: resolved (defaults are filled in). Replicates included, a shared filling is not.
CostEstimate predict_cost(const v1::Scene& resolved, const Calibration& calibration);

// The same scene within a budget of CPU seconds: how far one setting may go, the others as they
// are. Absent: does not fit whatever its value.
struct BudgetChoice {
  bool fits = false;                        // as it is, by the upper end of the interval
  std::optional<std::uint32_t> replicates;  // most
  std::optional<double> time_step_s;        // smallest
  std::optional<std::uint64_t> particles;   // most (count of a discharge, mass flow of a chute)
  std::optional<double> duration_s;         // longest (a chute)
};
BudgetChoice fit_budget(const v1::Scene& resolved, const Calibration& calibration, double budget_s);

}  // namespace granary
