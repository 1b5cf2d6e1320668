#include "server/studies/price.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "server/studies/price_rounds.h"
#include "server/studies/price_verdict.h"

namespace granary::server {
namespace {

constexpr unsigned kMostReplicates = 32;  // of the ladder of replicates

class PriceStudy : public StudyGenerator {
 public:
  PriceStudy(PricePlan plan, std::vector<std::string> observables)
      : plan_(std::move(plan)), observables_(std::move(observables)) {
    trials_.append(first_round(plan_));
  }

  std::vector<TrialProposal> ask(std::size_t limit) override {
    std::vector<TrialProposal> proposals;
    for (; proposals.size() < limit && proposed_ < trials_.size(); ++proposed_)
      proposals.push_back(proposal(trials_[proposed_]));
    return proposals;
  }

  TrialJudgement tell(std::uint32_t, const TrialOutcome& outcome) override {
    trials_.outcomes().add(outcome);
    plan_next_round();
    return {};
  }

  bool done() const override {
    return proposed_ == trials_.size() && (!climbs_in_rounds(plan_) || trials_.all_told());
  }
  // So far: rounds to come are not known.
  std::uint32_t planned() const override { return static_cast<std::uint32_t>(trials_.size()); }

  v1::StudySummary summary() const override;
  std::optional<Findings> findings() const override;

  std::string save() const override {
    return std::to_string(proposed_) + "\n" + trials_.outcomes().save();
  }
  void restore(const std::string& bytes) override;

 private:
  TrialProposal proposal(const PriceTrial& trial) const {
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

  void plan_next_round() {
    if (!trials_.all_told()) return;
    PriceRound round = next_round(plan_, trials_, observables_.front());
    trials_.append(round.trials);
    left_out_ = std::move(round.left_out);
  }

  template <typename Visit>
  void for_each_observable(const Ladder& ladder, Visit visit) const {
    for (const std::string& observable : observables_) {
      const std::vector<KnownRung> rungs = trials_.known(ladder, observable);
      if (!rungs.empty()) visit(observable, rungs, judge(ladder, rungs));
    }
  }

  void add_replicate_rungs(std::vector<PricePoint>& points) const;
  void report_ladder(const Ladder& ladder, v1::StudySummary& summary) const;

  PricePlan plan_;
  std::vector<std::string> observables_;
  PriceTrials trials_{plan_};  // points into plan_, which does not move
  std::size_t proposed_ = 0;
  std::vector<LeftOut> left_out_;  // of the last round that was planned
};

// The rounds are not saved: they follow from the outcomes.
void PriceStudy::restore(const std::string& bytes) {
  const std::size_t end = bytes.find('\n');
  if (end == std::string::npos) throw std::runtime_error("price: no state of its own");
  const std::size_t proposed = std::stoul(bytes.substr(0, end));
  OutcomeList saved;
  saved.restore(bytes.substr(end + 1));
  trials_ = PriceTrials(plan_);
  trials_.append(first_round(plan_));
  left_out_.clear();
  for (std::size_t told = 0; told < saved.size(); ++told) {
    if (trials_.all_told()) throw std::runtime_error("price: a state of another plan");
    trials_.outcomes().add(saved[told]);
    plan_next_round();
  }
  if (proposed > trials_.size() || saved.size() > proposed)
    throw std::runtime_error("price: a state of another plan");
  proposed_ = proposed;
}

void PriceStudy::report_ladder(const Ladder& ladder, v1::StudySummary& summary) const {
  auto& figures = *summary.mutable_figures();
  const std::string bar(1, kFigureSeparator);
  const KnownRung* knee = nullptr;
  std::vector<KnownRung> main_rungs;
  for_each_observable(
      ladder, [&](const std::string& observable, const std::vector<KnownRung>& rungs,
                  const LadderVerdict& verdict) {
        v1::Quantity& order = figures["order" + bar + ladder.path + bar + observable];
        if (verdict.order)
          order.set_value(*verdict.order);
        else
          order.set_error_basis(ladder.screening ? "screening" : "below noise");
        v1::Quantity& limit = figures["limit" + bar + ladder.path + bar + observable];
        limit.set_value(verdict.limit);
        limit.set_error(verdict.limit_half_width);
        for (const KnownRung& rung : rungs) {
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
        for (const KnownRung& rung : main_rungs)
          if (!difference(rung.level, finest).shows() &&
              (knee == nullptr || rung.outcome->cpu_s < knee->outcome->cpu_s))
            knee = &rung;
      });
  if (knee != nullptr) figures["knee" + bar + ladder.path].set_value(knee->rung->value);
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
  const auto say = [&verdict](const std::string& clause) {
    if (!clause.empty()) verdict += (verdict.empty() ? "" : "; ") + clause;
  };
  const std::string& observable = observables_.front();
  for (const Ladder& ladder : plan_.ladders) say(finest_clause(ladder, trials_, observable));
  say(target_clause(plan_, trials_, observable));
  say(budget_clause(plan_, trials_, left_out_));
  say(failure_clause(plan_, trials_));
  summary.set_verdict(verdict);
  return summary;
}

// The ladder of replicates is arithmetic: the spread between runs is known from all rungs together,
// those of other particles left out, whose number decides it.
void PriceStudy::add_replicate_rungs(std::vector<PricePoint>& points) const {
  const ShortOutcome* first = trials_.base();
  if (first == nullptr) return;
  const double one_run_s = first->cpu_s / plan_.base.replicates();
  for (const std::string& observable : observables_) {
    double squares = 0;
    unsigned degrees = 0;
    std::optional<LevelMean> base;
    for (const Ladder& ladder : plan_.ladders)
      for (const KnownRung& rung : trials_.known(ladder, observable)) {
        const bool is_base = rung.outcome == first;
        if (is_base ? base.has_value() : ladder.screening) continue;
        squares += (rung.level.count - 1) * rung.level.deviation * rung.level.deviation;
        degrees += rung.level.count - 1;
        if (is_base) base = rung.level;
      }
    if (!base || degrees == 0) continue;
    const double deviation = std::sqrt(squares / degrees);
    for (unsigned count = 1; count <= kMostReplicates; count *= 2)
      points.push_back({first->job, rung_name("replicates", count), observable, base->mean,
                        granary::student_t_95(degrees) * deviation / std::sqrt(count),
                        one_run_s * count});
  }
}

std::optional<Findings> PriceStudy::findings() const {
  Findings findings;
  add_replicate_rungs(findings.price);
  for (const Ladder& ladder : plan_.ladders)
    for_each_observable(
        ladder, [&](const std::string& observable, const std::vector<KnownRung>& rungs,
                    const LadderVerdict& verdict) {
          for (const KnownRung& rung : rungs)
            findings.price.push_back({rung.outcome->job, rung_name(ladder.path, rung.rung->value),
                                      observable, rung.level.mean,
                                      total_error(rung, rungs, verdict), rung.outcome->cpu_s});
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
