#include "server/studies/sweep.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <stdexcept>

#include "proto/contract/field_path.h"
#include "proto/contract/resolve.h"
#include "server/studies/random_stream.h"

namespace granary::server {
namespace {

using Inputs = std::map<std::string, std::string>;
using Variables = google::protobuf::RepeatedPtrField<v1::Sweep::Variable>;

constexpr std::size_t kMaxValidatedTrials = 2'000;

Error wrong(const std::string& field, const std::string& what) {
  return {ErrorCode::invalid_argument, "sweep." + field + ": " + what, "sweep." + field};
}

// ------------------------------------------------------------------------------------------- plans

std::vector<Inputs> grid(const Variables& vary) {
  std::vector<Inputs> plan{{}};
  for (const v1::Sweep::Variable& variable : vary) {
    std::vector<Inputs> longer;
    for (const Inputs& point : plan)
      for (const std::string& value : variable.values()) {
        longer.push_back(point);
        longer.back()[variable.path()] = value;
      }
    plan = std::move(longer);
  }
  return plan;
}

std::vector<Inputs> list(const Variables& vary) {
  std::vector<Inputs> plan(static_cast<std::size_t>(vary[0].values_size()));
  for (const v1::Sweep::Variable& variable : vary)
    for (int i = 0; i < variable.values_size(); ++i)
      plan[static_cast<std::size_t>(i)][variable.path()] = variable.values(i);
  return plan;
}

std::vector<std::size_t> shuffled(std::size_t count, RandomStream& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

// Six digits are more than a sweep needs, and labels stay readable.
std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// One point in each of `samples` strata of every variable, strata paired at random.
std::vector<Inputs> latin_hypercube(const v1::Sweep& sweep, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<Inputs> plan(sweep.samples());
  for (const v1::Sweep::Variable& variable : sweep.vary()) {
    const std::vector<std::size_t> strata = shuffled(plan.size(), random);
    for (std::size_t i = 0; i < plan.size(); ++i) {
      const double share =
          (static_cast<double>(strata[i]) + random.uniform()) / static_cast<double>(plan.size());
      std::string& value = plan[i][variable.path()];
      if (variable.values_size() > 0)
        value = variable.values(static_cast<int>(share * variable.values_size()));
      else
        value =
            short_number(variable.minimum() + share * (variable.maximum() - variable.minimum()));
    }
  }
  return plan;
}

// -------------------------------------------------------------------------------------- validation

Status check_variable(const v1::Sweep& sweep, int index) {
  const v1::Sweep::Variable& variable = sweep.vary(index);
  const std::string field = "vary[" + std::to_string(index) + "]";
  if (variable.path().empty()) return wrong(field + ".path", "is empty");
  for (int other = 0; other < index; ++other)
    if (sweep.vary(other).path() == variable.path())
      return wrong(field + ".path", variable.path() + " is varied twice");
  const bool range = variable.has_minimum() && variable.has_maximum();
  if (sweep.design() == v1::Sweep::LATIN_HYPERCUBE) {
    if (range == (variable.values_size() > 0))
      return wrong(field, "needs either values or minimum and maximum");
    if (range && !(variable.minimum() < variable.maximum()))
      return wrong(field + ".minimum", "must be below maximum");
    return Done{};
  }
  if (variable.values_size() == 0) return wrong(field + ".values", "is empty");
  if (variable.has_minimum() || variable.has_maximum())
    return wrong(field, "a range needs samples (LATIN_HYPERCUBE)");
  if (sweep.design() == v1::Sweep::LIST && variable.values_size() != sweep.vary(0).values_size())
    return wrong(field + ".values", "must have as many values as vary[0]");
  return Done{};
}

Status check_size(const v1::Sweep& sweep) {
  double trials = 1;
  if (sweep.design() == v1::Sweep::LATIN_HYPERCUBE) {
    trials = sweep.samples();
    if (trials < 1) return wrong("samples", "must be at least 1");
  } else if (sweep.has_samples()) {
    return wrong("samples", "is for LATIN_HYPERCUBE");
  } else if (sweep.design() == v1::Sweep::GRID) {
    for (const auto& variable : sweep.vary()) trials *= variable.values_size();
  } else {
    trials = sweep.vary(0).values_size();
  }
  if (trials > static_cast<double>(kMaxSweepTrials))
    return wrong("vary", "makes " + short_number(trials) + " trials, at most " +
                             std::to_string(kMaxSweepTrials) + " are allowed");
  return Done{};
}

Status check_spec(const v1::Sweep& sweep) {
  if (sweep.vary_size() == 0) return wrong("vary", "is empty: nothing to sweep");
  for (int i = 0; i < sweep.vary_size(); ++i)
    if (Status status = check_variable(sweep, i); !status) return status;
  return check_size(sweep);
}

Status check_scenes(const v1::Scene& base, const std::vector<Inputs>& plan) {
  const std::size_t stride = 1 + plan.size() / kMaxValidatedTrials;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    auto scene = scene_with(base, plan[i]);
    if (!scene) return scene.error();
    if (i % stride != 0) continue;
    if (auto resolved = resolve(*scene); !resolved)
      return Error{resolved.error().code,
                   "trial " + std::to_string(i + 1) + " (" + label_of(plan[i]) +
                       "): " + resolved.error().message,
                   resolved.error().field_path};
  }
  return Done{};
}

// --------------------------------------------------------------------------------------- generator

class SweepGenerator : public StudyGenerator {
 public:
  SweepGenerator(const v1::StudySpec& spec, std::vector<Inputs> plan)
      : base_(spec.scene()), design_(spec.sweep().design()), plan_(std::move(plan)) {}

  std::vector<TrialProposal> ask(std::size_t limit) override {
    static const std::map<v1::Sweep::Design, const char*> kRoles = {
        {v1::Sweep::GRID, "grid"},
        {v1::Sweep::LIST, "list"},
        {v1::Sweep::LATIN_HYPERCUBE, "latin hypercube"}};
    std::vector<TrialProposal> proposals;
    for (; proposals.size() < limit && !done(); ++proposed_) {
      TrialProposal proposal;
      proposal.inputs = plan_[proposed_];
      proposal.scene = scene_with(base_, proposal.inputs).value();  // check_scenes() made each once
      proposal.label = label_of(proposal.inputs);
      proposal.role = kRoles.at(design_);
      proposals.push_back(std::move(proposal));
    }
    return proposals;
  }

  TrialJudgement tell(std::uint32_t, const TrialOutcome& outcome) override {
    ++told_;
    if (outcome.state == v1::COMPLETE) ++complete_;
    return {};
  }

  bool done() const override { return proposed_ == plan_.size(); }
  std::uint32_t planned() const override { return static_cast<std::uint32_t>(plan_.size()); }

  v1::StudySummary summary() const override {
    v1::StudySummary summary;
    summary.set_verdict(std::to_string(complete_) + " of " + std::to_string(plan_.size()) +
                        " trials complete, " + std::to_string(told_ - complete_) + " failed");
    return summary;
  }

  std::string save() const override {
    return std::to_string(proposed_) + " " + std::to_string(told_) + " " +
           std::to_string(complete_);
  }
  void restore(const std::string& bytes) override {
    std::size_t proposed = 0, told = 0, complete = 0;
    if (std::sscanf(bytes.c_str(), "%zu %zu %zu", &proposed, &told, &complete) != 3 ||
        proposed > plan_.size() || told > proposed || complete > told)
      throw std::runtime_error("the saved state of a sweep is damaged");
    proposed_ = proposed;
    told_ = told;
    complete_ = complete;
  }

 private:
  v1::Scene base_;
  v1::Sweep::Design design_;
  std::vector<Inputs> plan_;
  std::size_t proposed_ = 0, told_ = 0, complete_ = 0;
};

}  // namespace

Result<std::unique_ptr<StudyGenerator>> make_sweep(const v1::StudySpec& spec) {
  const v1::Sweep& sweep = spec.sweep();
  if (Status status = check_spec(sweep); !status) return status.error();
  std::vector<Inputs> plan;
  if (sweep.design() == v1::Sweep::LATIN_HYPERCUBE)
    plan = latin_hypercube(sweep, spec.has_seed() ? spec.seed() : 1);
  else
    plan = sweep.design() == v1::Sweep::GRID ? grid(sweep.vary()) : list(sweep.vary());
  if (Status status = check_scenes(spec.scene(), plan); !status) return status.error();
  return std::unique_ptr<StudyGenerator>(std::make_unique<SweepGenerator>(spec, std::move(plan)));
}

}  // namespace granary::server
