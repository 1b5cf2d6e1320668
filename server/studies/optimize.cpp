#include "server/studies/optimize.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>

#include "proto/contract/field_path.h"
#include "server/studies/candidates.h"
#include "server/studies/optimize_settings.h"
#include "server/studies/pareto.h"

namespace granary::server {
namespace {

using nlohmann::json;

constexpr std::size_t kStart = 0;  // candidate number of x0

std::string plus_minus(double value, const std::optional<double>& error) {
  char text[64];
  if (error)
    std::snprintf(text, sizeof text, "%.4g +- %.2g", value, *error);
  else
    std::snprintf(text, sizeof text, "%.4g (spread unknown)", value);
  return text;
}

class OptimizeGenerator : public StudyGenerator {
 public:
  explicit OptimizeGenerator(OptimizeSettings settings)
      : settings_(std::move(settings)),
        noise_(settings_.optimize().noise()),
        objective_(settings_.optimize()),
        search_(make_search(settings_.optimize(), settings_.search_setup())),
        budget_(settings_.optimize().budget()) {
    candidates_.push_back({settings_.start, {}});
    plan_runs(kStart, noise_.replicates(), false, "start");
    next_batch();
  }

  // ---- the interface

  std::vector<TrialProposal> ask(std::size_t limit) override {
    std::vector<TrialProposal> proposals;
    for (; proposals.size() < limit && proposed_ < budget_ && !queue_.empty(); queue_.pop_front()) {
      const Planned planned = queue_.front();
      candidates_[planned.candidate].runs[planned.run].trial = ++proposed_;
      trials_.push_back({planned.candidate, planned.run});
      proposals.push_back(proposal_of(planned));
    }
    return proposals;
  }

  TrialJudgement tell(std::uint32_t trial, const TrialOutcome& outcome) override {
    const auto [number, index] = trials_.at(trial - 1);
    Candidate& candidate = candidates_[number];
    Run& run = candidate.runs[index];
    run.ended = true;
    if (outcome.state == v1::COMPLETE) run.reading = objective_.read(outcome.result);
    // x0 is told first; should it fail, the first result that comes sets the scale.
    if (run.reading && !objective_.has_scale()) objective_.set_scale(*run.reading);
    ++told_;
    const bool coarse = run.coarse;
    if (told_ == proposed_ && queue_.empty()) advance();
    return judge(candidates_[number], coarse);
  }

  bool done() const override { return finished_ || proposed_ >= budget_; }
  std::uint32_t planned() const override { return finished_ ? proposed_ : budget_; }

  Status extend(std::uint32_t budget) override {
    if (budget <= budget_ || budget > kMaxOptimizeTrials)
      return Error{ErrorCode::invalid_argument,
                   "budget: the new total must be above " + std::to_string(budget_) +
                       " and at most " + std::to_string(kMaxOptimizeTrials),
                   "budget"};
    budget_ = budget;
    if (finished_) {
      finished_ = false;
      next_batch();
    }
    return Done{};
  }

  v1::StudySummary summary() const override;
  std::optional<Findings> findings() const override;
  std::string save() const override;
  void restore(const std::string& bytes) override;

 private:
  struct Planned {
    std::size_t candidate;
    std::size_t run;
  };
  enum class Stage { coarse, full, decide };

  // ---- proposals

  void plan_runs(std::size_t candidate, std::size_t count, bool coarse, const std::string& role) {
    auto& runs = candidates_[candidate].runs;
    for (std::size_t i = 0; i < count; ++i) {
      const auto replicate = static_cast<std::uint32_t>(std::count_if(
          runs.begin(), runs.end(), [&](const Run& run) { return run.coarse == coarse; }));
      runs.push_back({replicate, coarse, 0, false, {}});
      queue_.push_back({candidate, runs.size() - 1});
      roles_[{candidate, runs.size() - 1}] = role;
    }
  }

  TrialProposal proposal_of(const Planned& planned) {
    const Candidate& candidate = candidates_[planned.candidate];
    const Run& run = candidate.runs[planned.run];
    TrialProposal proposal;
    proposal.inputs = settings_.inputs_at(candidate.point);
    proposal.label = label_of(proposal.inputs);
    proposal.scene = scene_with(settings_.spec.scene(), proposal.inputs).value();
    if (run.coarse)
      for (const std::string& setting : settings_.optimize().coarse().set()) {
        const auto equals = setting.find('=');
        (void)set_field(proposal.scene, setting.substr(0, equals), setting.substr(equals + 1));
      }
    // The same seeds for every candidate: what the filling does to all of them cancels.
    const std::uint64_t seed = proposal.scene.has_seed() ? proposal.scene.seed() : 0;
    if (run.replicate > 0) proposal.scene.set_seed(seed + run.replicate);
    proposal.role = run.replicate > 0 ? "replicate" : roles_.at({planned.candidate, planned.run});
    proposal.candidate = static_cast<std::uint32_t>(planned.candidate + 1);
    return proposal;
  }

  // ---- between batches

  // Everything that was proposed has been told.
  void advance() {
    if (stage_ == Stage::coarse) return promote();
    if (stage_ == Stage::decide) return decide();
    if (break_tie()) return;
    hand_over();
    if (reserve() > 0 && proposed_ + settings_.optimize().population() / 2 >= budget_ - reserve()) {
      stage_ = Stage::decide;
      return decide();
    }
    next_batch();
  }

  void next_batch() {
    const bool coarse = settings_.optimize().has_coarse();
    // A method may come back to known points only; it then gets their scores at once.
    for (int known_batches = 0; known_batches < 100; ++known_batches) {
      batch_.clear();
      const std::size_t before = queue_.size();
      for (const Point& point : search_->next_batch()) {
        const std::size_t number = candidate_at(point);
        batch_.push_back(number);
        const auto& runs = candidates_[number].runs;
        if (runs.empty())
          plan_runs(number, coarse ? 1 : noise_.replicates(), coarse, coarse ? "coarse" : "search");
      }
      stage_ = coarse ? Stage::coarse : Stage::full;
      if (queue_.size() > before || told_ < proposed_ || told_ == 0) return;
      hand_over();
    }
    finished_ = true;
  }

  // Points that give the same scene are one candidate.
  std::size_t candidate_at(const Point& point) {
    const auto inputs = settings_.inputs_at(point);
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      if (settings_.inputs_at(candidates_[i].point) == inputs) return i;
    candidates_.push_back({point, {}});
    return candidates_.size() - 1;
  }

  // The best share of a coarse batch is run again at full fidelity.
  void promote() {
    stage_ = Stage::full;
    std::vector<std::size_t> order(batch_);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return score_of(candidates_[a], objective_, true).merit >
             score_of(candidates_[b], objective_, true).merit;
    });
    const double share = settings_.optimize().coarse().promote();
    const auto count = static_cast<std::size_t>(
        std::max(1.0, std::round(share * static_cast<double>(order.size()))));
    for (std::size_t i = 0; i < std::min(count, order.size()); ++i)
      if (candidates_[order[i]].count(false) == 0 && candidates_[order[i]].first_trial() == 0)
        plan_runs(order[i], noise_.replicates(), false, "promoted");
    if (queue_.empty()) advance();
  }

  // One more run for the two best while nobody can tell which is better.
  bool break_tie() {
    if (noise_.replicates_max() <= noise_.replicates()) return false;
    const auto best = ranked();
    if (best.size() < 2 || is_decided(best[0], best[1])) return false;
    return replicate_pair(best[0], best[1]);
  }

  void decide() {
    const auto best = ranked();
    const bool open = !best.empty() && best[0] != kStart && !candidates_[kStart].failed(false) &&
                      !is_decided(best[0], kStart) && proposed_ < budget_;
    if (!open || !replicate_pair(best[0], kStart)) finished_ = true;
  }

  bool replicate_pair(std::size_t a, std::size_t b) {
    const std::size_t before = queue_.size();
    for (const std::size_t number : {a, b})
      if (candidates_[number].count(false) < noise_.replicates_max())
        plan_runs(number, 1, false, "replicate");
    return queue_.size() > before;
  }

  bool is_decided(std::size_t a, std::size_t b) const {
    const auto difference = paired_difference(candidates_[a], candidates_[b], objective_);
    return difference && difference->error && std::abs(difference->value) > *difference->error;
  }

  // Trials kept back for telling the best from x0 at the end.
  std::uint32_t reserve() const {
    const std::uint32_t more = noise_.replicates_max() - noise_.replicates();
    return std::min(2 * more, budget_ / 4);
  }

  void hand_over() {
    const double shift = coarse_shift();
    std::vector<Scored> scores;
    for (const std::size_t number : batch_) {
      const Candidate& candidate = candidates_[number];
      const bool coarse = candidate.count(false) == 0;
      Scored scored = score_of(candidate, objective_, coarse);
      if (coarse && scored.merit > kInfeasible) scored.merit += shift;
      scores.push_back(std::move(scored));
    }
    search_->take(scores);
  }

  // Mean of full minus coarse over the candidates that have both: coarse scores are moved by it, so
  // that a method does not follow the fidelity instead of the shape.
  double coarse_shift() const {
    std::vector<double> shifts;
    for (const std::size_t number : batch_) {
      const Candidate& candidate = candidates_[number];
      if (candidate.failed(true) || candidate.failed(false)) continue;
      shifts.push_back(merit_of(candidate, objective_, false).value -
                       merit_of(candidate, objective_, true).value);
    }
    return shifts.empty() ? 0 : mean_of(shifts).value;
  }

  // Candidates of full fidelity that hold every constraint, best first.
  std::vector<std::size_t> ranked() const {
    std::vector<std::pair<double, std::size_t>> merits;
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      if (!candidates_[i].failed(false) && violation_of(candidates_[i], false) == 0)
        merits.push_back({-merit_of(candidates_[i], objective_, false).value, i});
    std::sort(merits.begin(), merits.end());
    std::vector<std::size_t> order;
    for (const auto& [merit, number] : merits) order.push_back(number);
    return order;
  }

  TrialJudgement judge(const Candidate& candidate, bool coarse) const {
    if (candidate.failed(coarse)) return {};
    const Mean merit = merit_of(candidate, objective_, coarse);
    return {merit.value, merit.error, violation_of(candidate, coarse) == 0};
  }

  std::string verdict_of(std::size_t best) const;

  OptimizeSettings settings_;
  v1::Optimize::Noise noise_;
  Objective objective_;
  std::unique_ptr<SearchMethod> search_;
  std::vector<Candidate> candidates_;
  std::vector<std::size_t> batch_;
  Stage stage_ = Stage::full;
  std::deque<Planned> queue_;
  std::vector<std::pair<std::size_t, std::size_t>> trials_;  // candidate and run of trial i + 1
  std::map<std::pair<std::size_t, std::size_t>, std::string> roles_;  // of what is queued
  std::uint32_t proposed_ = 0, told_ = 0, budget_ = 0;
  bool finished_ = false;
};

// ----------------------------------------------------------------------------------------- results

std::string OptimizeGenerator::verdict_of(std::size_t best) const {
  const Mean merit = merit_of(candidates_[best], objective_, false);
  const std::string what = "best " + plus_minus(merit.value, merit.error) + " at trial " +
                           std::to_string(candidates_[best].first_trial());
  if (best == kStart) return what + ": nothing better than the start was found";
  auto gain = paired_difference(candidates_[best], candidates_[kStart], objective_);
  if (!gain) return what;
  if (!gain->error && merit.error) {
    const Mean start = merit_of(candidates_[kStart], objective_, false);
    if (start.error) gain->error = std::hypot(*merit.error, *start.error);
  }
  const std::string by = plus_minus(gain->value, gain->error);
  if (gain->error && gain->value <= *gain->error)
    return what + ": no significant improvement over the start (" + by + ")";
  return what + ", " + by + " better than the start";
}

v1::StudySummary OptimizeGenerator::summary() const {
  v1::StudySummary summary;
  const auto best = ranked();
  if (best.empty()) {
    if (told_ > 0)
      summary.set_verdict("no run so far gives every value and holds every constraint");
    return summary;
  }
  const Mean merit = merit_of(candidates_[best[0]], objective_, false);
  summary.set_best_trial(candidates_[best[0]].first_trial());
  summary.set_best_objective(merit.value);
  if (merit.error) summary.set_best_objective_error(*merit.error);
  for (const auto& [path, value] : settings_.inputs_at(candidates_[best[0]].point))
    (*summary.mutable_best_inputs())[path] = value;
  if (!candidates_[kStart].failed(false)) {
    const Mean start = merit_of(candidates_[kStart], objective_, false);
    v1::Quantity& figure = (*summary.mutable_figures())["start_objective"];
    figure.set_value(start.value);
    if (start.error) figure.set_error(*start.error);
  }
  summary.set_verdict(verdict_of(best[0]));
  return summary;
}

std::optional<Findings> OptimizeGenerator::findings() const {
  const auto order = ranked();
  std::vector<std::vector<double>> points;
  for (const std::size_t number : order)
    points.push_back(objective_.directed(terms_of(candidates_[number], false)));
  Findings findings;
  for (const std::size_t index : pareto_front(points))
    findings.pareto.push_back(candidates_[order[index]].first_trial());
  std::sort(findings.pareto.begin(), findings.pareto.end());
  return findings;
}

// ------------------------------------------------------------------------------------------- state

std::string OptimizeGenerator::save() const {
  json state = {{"search", search_->save()},
                {"scale", objective_.scale()},
                {"batch", batch_},
                {"stage", static_cast<int>(stage_)},
                {"trials", trials_},
                {"proposed", proposed_},
                {"told", told_},
                {"budget", budget_},
                {"finished", finished_}};
  for (const Candidate& candidate : candidates_) state["candidates"].push_back(to_json(candidate));
  state["queue"] = json::array();
  for (const Planned& planned : queue_)
    state["queue"].push_back(
        {planned.candidate, planned.run, roles_.at({planned.candidate, planned.run})});
  const auto bytes = json::to_cbor(state);
  return {bytes.begin(), bytes.end()};
}

void OptimizeGenerator::restore(const std::string& bytes) try {
  const json state = json::from_cbor(bytes);
  search_->restore(state.at("search"));
  objective_.restore_scale(state.at("scale").get<std::vector<double>>());
  batch_ = state.at("batch").get<std::vector<std::size_t>>();
  stage_ = static_cast<Stage>(state.at("stage").get<int>());
  trials_ = state.at("trials").get<decltype(trials_)>();
  proposed_ = state.at("proposed");
  told_ = state.at("told");
  budget_ = state.at("budget");
  finished_ = state.at("finished");
  candidates_.clear();
  for (const json& candidate : state.at("candidates"))
    candidates_.push_back(candidate_from(candidate));
  queue_.clear();
  roles_.clear();
  for (const json& planned : state.at("queue")) {
    queue_.push_back({planned.at(0), planned.at(1)});
    roles_[{planned.at(0), planned.at(1)}] = planned.at(2);
  }
} catch (const json::exception& damage) {
  throw std::runtime_error(std::string("the saved state of an optimization is damaged: ") +
                           damage.what());
}

}  // namespace

Result<std::unique_ptr<StudyGenerator>> make_optimize(const v1::StudySpec& spec) {
  auto settings = read_settings(spec);
  if (!settings) return settings.error();
  return std::unique_ptr<StudyGenerator>(std::make_unique<OptimizeGenerator>(std::move(*settings)));
}

}  // namespace granary::server
