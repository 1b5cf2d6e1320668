#include "server/studies/ablate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "proto/contract/ladder.h"
#include "proto/contract/resolve.h"
#include "server/studies/outcome_list.h"

namespace granary::server {
namespace {

struct Variant {
  std::string name;  // of the effect, or path=value
  std::map<std::string, std::string> inputs;
  bool is_effect = false;
  bool base_has_it = false;
  v1::EffectReport report;
  std::string refusal;  // why there is no trial of it
};

// Effects stay as the base scene has them, so that one is changed at a time; a changed setting may
// call for others (a rolling friction that was zero), so there they are decided anew.
v1::Scene variant_base(v1::Scene base, const v1::Effects& as_written, const Variant& variant) {
  if (!variant.is_effect) *base.mutable_effects() = as_written;
  return base;
}

class AblateStudy : public StudyGenerator {
 public:
  AblateStudy(v1::Scene base, v1::Effects as_written, std::vector<Variant> variants,
              std::vector<std::string> observables)
      : base_(std::move(base)),
        as_written_(std::move(as_written)),
        variants_(std::move(variants)),
        observables_(std::move(observables)) {
    for (std::size_t k = 0; k < variants_.size(); ++k)
      if (variants_[k].refusal.empty()) trials_.push_back(k);
  }

  std::vector<TrialProposal> ask(std::size_t limit) override {
    std::vector<TrialProposal> proposals;
    for (; proposals.size() < limit && proposed_ < planned(); ++proposed_)
      proposals.push_back(proposal(proposed_));
    return proposals;
  }
  TrialJudgement tell(std::uint32_t, const TrialOutcome& outcome) override {
    outcomes_.add(outcome);
    return {};
  }
  bool done() const override { return proposed_ == planned(); }
  std::uint32_t planned() const override { return static_cast<std::uint32_t>(trials_.size() + 1); }

  v1::StudySummary summary() const override;
  std::optional<Findings> findings() const override;

  std::string save() const override { return std::to_string(proposed_) + "\n" + outcomes_.save(); }
  void restore(const std::string& bytes) override {
    const std::size_t end = bytes.find('\n');
    if (end == std::string::npos) throw std::runtime_error("ablate: no state of its own");
    proposed_ = static_cast<std::uint32_t>(std::stoul(bytes.substr(0, end)));
    outcomes_.restore(bytes.substr(end + 1));
    if (proposed_ > planned() || outcomes_.size() > proposed_)
      throw std::runtime_error("ablate: a state of another plan");
  }

 private:
  TrialProposal proposal(std::uint32_t trial) const {
    TrialProposal proposal;
    proposal.scene = base_;
    proposal.label = proposal.role = "base";
    if (trial == 0) return proposal;
    const Variant& variant = variants_[trials_[trial - 1]];
    proposal.inputs = variant.inputs;
    proposal.scene = scene_with(variant_base(base_, as_written_, variant), variant.inputs).value();
    proposal.label = label_of(variant.inputs);
    proposal.role = "variant";
    return proposal;
  }

  std::optional<LevelMean> level(const ShortOutcome& outcome, const std::string& name) const {
    const auto found = outcome.values.find(name);
    if (!outcome.complete || found == outcome.values.end() || !found->second.value) return {};
    return level_of(*found->second.value, found->second.error.value_or(0), base_.replicates());
  }

  // With the effect minus without it; of a setting, its value minus the base scene's.
  std::vector<EffectDelta> deltas() const;

  v1::Scene base_;
  v1::Effects as_written_;
  std::vector<Variant> variants_;
  std::vector<std::string> observables_;
  std::vector<std::size_t> trials_;  // index into variants_ of trials 2, 3, ...
  std::uint32_t proposed_ = 0;
  OutcomeList outcomes_;
};

std::vector<EffectDelta> AblateStudy::deltas() const {
  std::vector<EffectDelta> rows;
  if (outcomes_.size() == 0) return rows;
  for (std::size_t t = 0; t < trials_.size() && t + 1 < outcomes_.size(); ++t) {
    const Variant& variant = variants_[trials_[t]];
    const ShortOutcome& base = outcomes_[0];
    const ShortOutcome& other = outcomes_[t + 1];
    const bool base_is_with = variant.is_effect && variant.base_has_it;
    const ShortOutcome& with = base_is_with ? base : other;
    const ShortOutcome& without = base_is_with ? other : base;
    for (const std::string& observable : observables_) {
      const auto a = level(with, observable), b = level(without, observable);
      if (!a || !b) continue;
      const Difference delta = difference(*a, *b);
      const auto ratio =
          without.cpu_s > 0 ? std::optional(with.cpu_s / without.cpu_s) : std::nullopt;
      rows.push_back({variant.name, observable, delta.value, delta.half_width, ratio});
    }
  }
  return rows;
}

std::optional<Findings> AblateStudy::findings() const {
  Findings findings;
  findings.effects = deltas();
  return findings;
}

v1::StudySummary AblateStudy::summary() const {
  v1::StudySummary summary;
  auto& figures = *summary.mutable_figures();
  for (const Variant& variant : variants_) {
    if (!variant.refusal.empty())
      figures["unavailable|" + variant.name].set_error_basis(variant.refusal);
    if (!variant.is_effect) continue;
    v1::Quantity& on = figures["on|" + variant.name];
    on.set_value(variant.base_has_it ? 1 : 0);
    on.set_error_basis(variant.report.reason());
  }
  for (std::size_t t = 0; t + 1 < outcomes_.size(); ++t)
    if (!outcomes_[t + 1].complete)
      figures["unavailable|" + variants_[trials_[t]].name].set_error_basis(outcomes_[t + 1].error);
  std::string shown;
  for (const EffectDelta& row : deltas()) {
    const auto scale = level(outcomes_[0], row.observable);
    if (scale && scale->mean != 0) {
      v1::Quantity& relative = figures["relative|" + row.effect + "|" + row.observable];
      relative.set_value(*row.delta / std::abs(scale->mean));
      relative.set_error(*row.error / std::abs(scale->mean));
    }
    if (std::abs(*row.delta) <= *row.error || shown.find(row.effect) != std::string::npos) continue;
    shown += (shown.empty() ? "" : ", ") + row.effect;
  }
  if (!outcomes_.size()) return summary;
  summary.set_verdict(shown.empty() ? "no difference beyond its error" : "shows: " + shown);
  return summary;
}

Variant effect_variant(const std::string& name, const v1::EffectReport& report,
                       const v1::Scene& base) {
  Variant variant{name, {}, true, report.on(), report, ""};
  variant.inputs["effects." + name] = report.on() ? "OFF" : "ON";
  auto scene = scene_with(base, variant.inputs);
  if (!scene) variant.refusal = scene.error().message;
  if (scene)
    if (auto resolved = resolve(*scene); !resolved) variant.refusal = resolved.error().message;
  return variant;
}

Result<Variant> setting_variant(const std::string& text, const v1::StudySpec& spec,
                                const v1::Scene& base) {
  const std::size_t equals = text.find('=');
  Variant variant{text, {{text.substr(0, equals), text.substr(equals + 1)}}, false, false, {}, ""};
  auto scene = scene_with(variant_base(base, spec.scene().effects(), variant), variant.inputs);
  if (!scene) return scene.error();
  if (auto resolved = resolve(*scene); !resolved) return resolved.error();
  return variant;
}

Result<std::vector<Variant>> variants_of(const v1::StudySpec& spec, const ResolvedScene& resolved,
                                         const v1::Scene& base) {
  std::vector<Variant> variants;
  const auto switchable = [&](const std::string& name) {
    return v1::Effects::descriptor()->FindFieldByName(name) != nullptr;
  };
  for (const std::string& asked : spec.ablate().effect()) {
    if (asked.find('=') != std::string::npos) {
      auto variant = setting_variant(asked, spec, base);
      if (!variant) return variant.error();
      variants.push_back(std::move(*variant));
      continue;
    }
    const auto report = resolved.effects.find(asked);
    if (report == resolved.effects.end() || !switchable(asked))
      return Error{ErrorCode::invalid_argument,
                   "ablate.effect: knows no " + asked +
                       ", must be gas, rotating_frame, rolling_friction, particle_rotation, "
                       "tangential_history, cohesion or path=value",
                   "ablate.effect"};
    variants.push_back(effect_variant(asked, report->second, base));
  }
  if (!variants.empty()) return variants;
  for (const auto& [name, report] : resolved.effects)
    if (switchable(name)) variants.push_back(effect_variant(name, report, base));
  return variants;
}

}  // namespace

Result<std::unique_ptr<StudyGenerator>> make_ablate(const v1::StudySpec& spec) {
  const v1::Ablate& ablate = spec.ablate();
  if (ablate.has_replicates() && (ablate.replicates() < 2 || ablate.replicates() > 100))
    return Error{ErrorCode::invalid_argument,
                 "ablate.replicates: must be >= 2 and <= 100: a single run has no error bar",
                 "ablate.replicates"};
  auto resolved = resolve(spec.scene());
  if (!resolved) return resolved.error();
  v1::Scene base = spec.scene();
  base.clear_accuracy();
  *base.mutable_effects() = resolved->scene.effects();
  base.set_replicates(ablate.has_replicates() ? ablate.replicates() : kDefaultAblateReplicates);
  auto variants = variants_of(spec, *resolved, base);
  if (!variants) return variants.error();
  std::vector<std::string> observables(ablate.observable().begin(), ablate.observable().end());
  if (observables.empty()) observables = main_observables(spec.scene());
  return std::unique_ptr<StudyGenerator>(std::make_unique<AblateStudy>(
      std::move(base), spec.scene().effects(), std::move(*variants), std::move(observables)));
}

}  // namespace granary::server
