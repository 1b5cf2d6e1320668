#include "server/studies/price.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "proto/contract/ladder.h"
#include "server/studies/outcome_list.h"
#include "server/studies/price_ladder.h"

namespace granary::server {
namespace {

constexpr unsigned kMostReplicates = 32;  // of the ladder of replicates

class PriceStudy : public StudyGenerator {
 public:
  PriceStudy(PricePlan plan, std::vector<std::string> observables)
      : plan_(std::move(plan)), observables_(std::move(observables)) {
    trials_.push_back({nullptr, nullptr});  // the base scene belongs to every ladder
    for (const Ladder& ladder : plan_.ladders)
      for (const Rung& rung : ladder.rungs)
        if (!rung.inputs.empty()) trials_.push_back({&ladder, &rung});
  }

  std::vector<TrialProposal> ask(std::size_t limit) override {
    std::vector<TrialProposal> proposals;
    for (; proposals.size() < limit && proposed_ < trials_.size(); ++proposed_)
      proposals.push_back(proposal(trials_[proposed_]));
    return proposals;
  }

  TrialJudgement tell(std::uint32_t, const TrialOutcome& outcome) override {
    outcomes_.add(outcome);
    return {};
  }

  bool done() const override { return proposed_ == trials_.size(); }
  std::uint32_t planned() const override { return static_cast<std::uint32_t>(trials_.size()); }

  v1::StudySummary summary() const override;
  std::optional<Findings> findings() const override;

  std::string save() const override { return std::to_string(proposed_) + "\n" + outcomes_.save(); }
  void restore(const std::string& bytes) override {
    const std::size_t end = bytes.find('\n');
    if (end == std::string::npos) throw std::runtime_error("price: no state of its own");
    proposed_ = std::stoul(bytes.substr(0, end));
    outcomes_.restore(bytes.substr(end + 1));
    if (proposed_ > trials_.size() || outcomes_.size() > proposed_)
      throw std::runtime_error("price: a state of another plan");
  }

 private:
  struct Trial {
    const Ladder* ladder;
    const Rung* rung;
  };
  // A rung whose trial has ended well.
  struct Known {
    const Rung* rung;
    const ShortOutcome* outcome;
    LevelMean level;
  };

  TrialProposal proposal(const Trial& trial) const {
    TrialProposal proposal;
    if (trial.rung == nullptr) {
      proposal.scene = plan_.base;
      proposal.label = "base";
      proposal.role = "base";
      return proposal;
    }
    proposal.inputs = trial.rung->inputs;
    proposal.scene = scene_with(plan_.base, proposal.inputs).value();
    proposal.label = label_of({{trial.ladder->path, trial.rung->inputs.at(trial.ladder->path)}});
    proposal.role = "rung";
    return proposal;
  }

  const ShortOutcome* outcome_of(const Ladder& ladder, std::size_t rung) const {
    std::size_t trial = 0;
    if (rung != ladder.base)
      trial = static_cast<std::size_t>(
          std::find_if(trials_.begin(), trials_.end(),
                       [&](const Trial& t) { return t.rung == &ladder.rungs[rung]; }) -
          trials_.begin());
    return trial < outcomes_.size() && outcomes_[trial].complete ? &outcomes_[trial] : nullptr;
  }

  std::vector<Known> known(const Ladder& ladder, const std::string& observable) const {
    std::vector<Known> rungs;
    for (std::size_t k = 0; k < ladder.rungs.size(); ++k) {
      const ShortOutcome* outcome = outcome_of(ladder, k);
      if (outcome == nullptr) continue;
      const auto found = outcome->values.find(observable);
      if (found == outcome->values.end() || !found->second.value) continue;
      rungs.push_back({&ladder.rungs[k], outcome,
                       level_of(*found->second.value, found->second.error.value_or(0),
                                plan_.base.replicates())});
    }
    return rungs;
  }

  template <typename Visit>
  void for_each_observable(const Ladder& ladder, Visit visit) const {
    for (const std::string& observable : observables_) {
      const std::vector<Known> rungs = known(ladder, observable);
      if (rungs.empty()) continue;
      std::vector<LevelMean> levels;
      for (const Known& rung : rungs) levels.push_back(rung.level);
      visit(observable, rungs, judge_ladder(levels, ladder.ratio));
    }
  }

  static double total_error(const Known& rung, const std::vector<Known>& rungs,
                            const LadderVerdict& verdict) {
    const LevelMean& level = rung.level;
    const double sampling = difference(level, {level.mean, 0, level.count}).half_width;
    return std::hypot(bias_bound(level, rungs.back().level, verdict), sampling);
  }

  void add_replicate_rungs(std::vector<PricePoint>& points) const;
  void report_ladder(const Ladder& ladder, v1::StudySummary& summary) const;
  std::string finest_bought(const Ladder& ladder) const;

  PricePlan plan_;
  std::vector<std::string> observables_;
  std::vector<Trial> trials_;  // point into plan_, which does not move
  std::size_t proposed_ = 0;
  OutcomeList outcomes_;
};

void PriceStudy::report_ladder(const Ladder& ladder, v1::StudySummary& summary) const {
  auto& figures = *summary.mutable_figures();
  const std::string bar(1, kFigureSeparator);
  const Known* knee = nullptr;
  std::vector<Known> main_rungs;
  for_each_observable(ladder, [&](const std::string& observable, const std::vector<Known>& rungs,
                                  const LadderVerdict& verdict) {
    v1::Quantity& order = figures["order" + bar + ladder.path + bar + observable];
    if (verdict.order)
      order.set_value(*verdict.order);
    else
      order.set_error_basis("below noise");
    v1::Quantity& limit = figures["limit" + bar + ladder.path + bar + observable];
    limit.set_value(verdict.limit);
    limit.set_error(verdict.limit_half_width);
    for (const Known& rung : rungs) {
      const Difference off = difference(rung.level, rungs.back().level);
      v1::Quantity& bias =
          figures["bias" + bar + rung_name(ladder.path, rung.rung->value) + bar + observable];
      bias.set_value(rung.level.mean - verdict.limit);
      bias.set_error(off.half_width);
      bias.set_error_basis(&rung == &rungs.back() ? "finest"
                           : off.shows()          ? "shows"
                                                  : "below noise");
      const std::string name = rung_name(ladder.path, rung.rung->value);
      figures["memory" + bar + name].set_value(rung.outcome->peak_rss_bytes);
      figures["remainder" + bar + name].set_value(rung.outcome->ledger_remainder_ratio);
    }
    if (!main_rungs.empty()) return;  // the first observable decides the knee
    main_rungs = rungs;
    const LevelMean& finest = main_rungs.back().level;
    for (const Known& rung : main_rungs)
      if (!difference(rung.level, finest).shows() &&
          (knee == nullptr || rung.outcome->cpu_s < knee->outcome->cpu_s))
        knee = &rung;
  });
  if (knee != nullptr) figures["knee" + bar + ladder.path].set_value(knee->rung->value);
}

// What the finest rung has brought beyond the base scene's own, in the first observable.
std::string PriceStudy::finest_bought(const Ladder& ladder) const {
  const std::vector<Known> rungs = known(ladder, observables_.front());
  const auto base = std::find_if(rungs.begin(), rungs.end(),
                                 [](const Known& rung) { return rung.rung->inputs.empty(); });
  if (base == rungs.end() || base + 1 == rungs.end()) return "";
  const Known& finest = rungs.back();
  const Difference off = difference(finest.level, base->level);
  char text[256];
  std::snprintf(text, sizeof text,
                "; %s instead of %.6g: %s %+.2g +- %.1g (%s), ledger remainder %.1e instead of "
                "%.1e, %.1f times the CPU",
                rung_name(ladder.path, finest.rung->value).c_str(), base->rung->value,
                observables_.front().c_str(), off.value, off.half_width,
                off.shows() ? "shows" : "below noise", finest.outcome->ledger_remainder_ratio,
                base->outcome->ledger_remainder_ratio,
                finest.outcome->cpu_s / base->outcome->cpu_s);
  return text;
}

v1::StudySummary PriceStudy::summary() const {
  v1::StudySummary summary;
  std::string verdict;
  for (const Ladder& ladder : plan_.ladders) {
    report_ladder(ladder, summary);
    const auto knee = summary.figures().find("knee|" + ladder.path);
    if (knee == summary.figures().end()) continue;
    verdict += (verdict.empty() ? "knee: " : ", ") + rung_name(ladder.path, knee->second.value());
  }
  for (const Ladder& ladder : plan_.ladders) verdict += finest_bought(ladder);
  summary.set_verdict(verdict);
  return summary;
}

// The ladder of replicates is arithmetic: the spread between runs is known from all rungs together.
void PriceStudy::add_replicate_rungs(std::vector<PricePoint>& points) const {
  if (outcomes_.size() == 0 || !outcomes_[0].complete) return;
  const double one_run_s = outcomes_[0].cpu_s / plan_.base.replicates();
  for (const std::string& observable : observables_) {
    double squares = 0;
    unsigned degrees = 0;
    std::optional<LevelMean> base;
    for (const Ladder& ladder : plan_.ladders)
      for (const Known& rung : known(ladder, observable)) {
        squares += (rung.level.count - 1) * rung.level.deviation * rung.level.deviation;
        degrees += rung.level.count - 1;
        if (rung.rung->inputs.empty()) base = rung.level;
      }
    if (!base || degrees == 0) continue;
    const double deviation = std::sqrt(squares / degrees);
    for (unsigned count = 1; count <= kMostReplicates; count *= 2)
      points.push_back({outcomes_[0].job, rung_name("replicates", count), observable, base->mean,
                        granary::student_t_95(degrees) * deviation / std::sqrt(count),
                        one_run_s * count});
  }
}

std::optional<Findings> PriceStudy::findings() const {
  Findings findings;
  add_replicate_rungs(findings.price);
  for (const Ladder& ladder : plan_.ladders)
    for_each_observable(ladder, [&](const std::string& observable, const std::vector<Known>& rungs,
                                    const LadderVerdict& verdict) {
      for (const Known& rung : rungs)
        findings.price.push_back({rung.outcome->job, rung_name(ladder.path, rung.rung->value),
                                  observable, rung.level.mean, total_error(rung, rungs, verdict),
                                  rung.outcome->cpu_s});
    });
  return findings;
}

std::vector<std::string> observables_of(const v1::StudySpec& spec) {
  const auto& asked = spec.price().observable();
  std::vector<std::string> names(asked.begin(), asked.end());
  if (names.empty() && spec.scene().accuracy().has_observable())
    names.push_back(spec.scene().accuracy().observable());
  return names.empty() ? main_observables(spec.scene()) : names;
}

}  // namespace

std::string rung_name(const std::string& path, double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return path + "=" + text;
}

Result<std::unique_ptr<StudyGenerator>> make_price(const v1::StudySpec& spec) {
  auto plan = plan_price(spec);
  if (!plan) return plan.error();
  return std::unique_ptr<StudyGenerator>(
      std::make_unique<PriceStudy>(std::move(*plan), observables_of(spec)));
}

}  // namespace granary::server
