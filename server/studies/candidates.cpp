#include "server/studies/candidates.h"

#include <algorithm>

namespace granary::server {

using nlohmann::json;

std::size_t Candidate::count(bool coarse) const {
  return static_cast<std::size_t>(std::count_if(
      runs.begin(), runs.end(), [&](const Run& run) { return run.ended && run.coarse == coarse; }));
}

std::uint32_t Candidate::first_trial() const {
  for (const Run& run : runs)
    if (!run.coarse && run.trial > 0) return run.trial;
  return 0;
}

bool Candidate::failed(bool coarse) const {
  return readings(coarse).empty();
}

std::vector<const Reading*> Candidate::readings(bool coarse) const {
  std::vector<const Reading*> out;
  for (const Run& run : runs)
    if (run.ended && run.coarse == coarse && run.reading) out.push_back(&*run.reading);
  return out;
}

double violation_of(const Candidate& candidate, bool coarse) {
  const auto readings = candidate.readings(coarse);
  double sum = 0;
  for (const Reading* reading : readings) sum += reading->violation;
  return sum / static_cast<double>(readings.size());
}

std::vector<double> terms_of(const Candidate& candidate, bool coarse) {
  const auto readings = candidate.readings(coarse);
  std::vector<double> mean(readings.front()->terms.size(), 0);
  for (const Reading* reading : readings)
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] += reading->terms[i] / static_cast<double>(readings.size());
  return mean;
}

Mean merit_of(const Candidate& candidate, const Objective& objective, bool coarse) {
  const auto readings = candidate.readings(coarse);
  std::vector<double> merits;
  for (const Reading* reading : readings) merits.push_back(objective.merit(reading->terms));
  Mean mean = mean_of(merits);
  // One run: what the run itself says of its errors, if it does.
  if (merits.size() == 1) mean.error = objective.merit_error(readings.front()->errors);
  return mean;
}

Scored score_of(const Candidate& candidate, const Objective& objective, bool coarse) {
  Scored scored{candidate.point, kFailed, std::vector<double>(objective.size(), kFailed)};
  if (candidate.failed(coarse)) return scored;
  const double violation = violation_of(candidate, coarse);
  if (violation > 0) {
    scored.merit = kInfeasible * (1 + violation);
    std::fill(scored.terms.begin(), scored.terms.end(), scored.merit);
    return scored;
  }
  scored.merit = merit_of(candidate, objective, coarse).value;
  scored.terms = objective.directed(terms_of(candidate, coarse));
  return scored;
}

std::optional<Mean> paired_difference(const Candidate& a, const Candidate& b,
                                      const Objective& objective) {
  std::vector<double> differences;
  for (const Run& one : a.runs)
    for (const Run& other : b.runs)
      if (one.reading && other.reading && !one.coarse && !other.coarse &&
          one.replicate == other.replicate)
        differences.push_back(objective.merit(one.reading->terms) -
                              objective.merit(other.reading->terms));
  if (differences.empty()) return {};
  return mean_of(differences);
}

json to_json(const Candidate& candidate) {
  json runs = json::array();
  for (const Run& run : candidate.runs) {
    json reading = nullptr;
    if (run.reading) reading = {run.reading->terms, run.reading->errors, run.reading->violation};
    runs.push_back({run.replicate, run.coarse, run.trial, run.ended, reading});
  }
  return {candidate.point, runs};
}

Candidate candidate_from(const json& state) {
  Candidate candidate{state.at(0).get<Point>(), {}};
  for (const json& run : state.at(1)) {
    Run read{run.at(0), run.at(1), run.at(2), run.at(3), {}};
    if (const json& r = run.at(4); !r.is_null())
      read.reading = Reading{r.at(0).get<std::vector<double>>(), r.at(1).get<std::vector<double>>(),
                             r.at(2).get<double>()};
    candidate.runs.push_back(std::move(read));
  }
  return candidate;
}

}  // namespace granary::server
