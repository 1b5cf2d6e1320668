// The candidates of an optimization: points with their runs (other filling seeds, other fidelity),
// the mean of each with its interval, and who is better than whom as far as the runs can tell.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "server/studies/objective.h"
#include "server/studies/search_method.h"
#include "server/studies/statistics.h"

namespace granary::server {

struct Run {
  std::uint32_t replicate = 0;  // seed = the base scene's + replicate
  bool coarse = false;
  std::uint32_t trial = 0;
  bool ended = false;
  std::optional<Reading> reading;  // nothing = failed
};

struct Candidate {
  Point point;
  std::vector<Run> runs;

  std::size_t count(bool coarse) const;  // ended ones of this fidelity
  std::uint32_t first_trial() const;     // of full fidelity; 0 = none
  bool failed(bool coarse) const;        // all of its ended runs failed
  std::vector<const Reading*> readings(bool coarse) const;
};

// Means over the runs that gave something. Precondition of the first three: there is one.
double violation_of(const Candidate& candidate, bool coarse);
std::vector<double> terms_of(const Candidate& candidate, bool coarse);
Mean merit_of(const Candidate& candidate, const Objective& objective, bool coarse);

// As search methods see it: constraints and failures below everything else.
Scored score_of(const Candidate& candidate, const Objective& objective, bool coarse);

// a minus b over the seeds both have run: paired, so what the filling does to both cancels.
std::optional<Mean> paired_difference(const Candidate& a, const Candidate& b,
                                      const Objective& objective);

nlohmann::json to_json(const Candidate& candidate);
Candidate candidate_from(const nlohmann::json& json);

}  // namespace granary::server
