#include "worker/run/accuracy_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "proto/contract/cost_model.h"
#include "worker/run/accuracy_plan.h"
#include "worker/run/cost_clock.h"
#include "worker/run/run_task.h"

namespace granary::run {
namespace {

constexpr unsigned kFirstReplicates = 4;
constexpr int kMostRounds = 4;          // of pilots, each with as many new replicates as all before
constexpr double kPilotShare = 0.5;     // of a budget
constexpr double kPilotProgress = 0.4;  // of the progress bar

// Of the stiffness pilot, in the h that the error goes with (accuracy_plan.cpp).
double stiffness_ratio(const v1::Scene& scene) {
  return scene.has_chute() ? 2 : 10;
}

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g %%", 100 * share);
  return text;
}

std::optional<unsigned> fixed_replicates(const TaskSpec& spec) {
  for (const v1::Decision& decision : spec.decisions)
    if (decision.path() == "replicates" && decision.chosen_by() == "user")
      return spec.scene.replicates();
  return std::nullopt;
}

v1::Decision decision(const std::string& path, double value, const std::string& evidence) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", value);
  v1::Decision decision;
  decision.set_path(path);
  decision.set_value(text);
  decision.set_chosen_by("auto");
  decision.set_evidence(evidence);
  return decision;
}

class AccuracyRun {
 public:
  AccuracyRun(const TaskSpec& spec, const SimulationFactory& factory,
              const TaskCallbacks& callbacks, const StopSignal& stop, storage::FileSystem& files)
      : spec_(spec), factory_(factory), callbacks_(callbacks), stop_(stop), files_(files) {}

  TaskOutcome execute() {
    for (const Pilot pilot :
         {Pilot::base, Pilot::fine_step, Pilot::coarse_step, Pilot::stiff, Pilot::tight})
      if (auto scene = pilot_scene(pilot, spec_.scene, spec_.decisions))
        scenes_.emplace(pilot, std::move(*scene));
    for (int round = 0; round < kMostRounds; ++round) {
      if (const auto failed = run_round(round)) return *failed;
      if (!means_.contains(observable())) return unknown_observable();
      choice_ = choose(means_.at(observable()), costs(), target(), stiffness_ratio(spec_.scene),
                       fixed_replicates(spec_));
      if (choice_.meets || !choice_.noise_limits || !another_round_pays()) break;
    }
    return run_main();
  }

 private:
  const std::string& observable() const { return spec_.scene.accuracy().observable(); }
  double target() const { return spec_.scene.accuracy().target(); }
  double budget_s() const {
    return spec_.scene.accuracy().has_budget_s() ? spec_.scene.accuracy().budget_s() : 0;
  }

  // ---- pilots

  // Replicates of a round have their own seeds; the first round's are those of the main run.
  v1::Scene pilot_of_round(Pilot pilot, int round) const {
    v1::Scene scene = scenes_.at(pilot);
    scene.set_replicates(round == 0 ? kFirstReplicates : kFirstReplicates << (round - 1));
    if (round > 0) scene.set_seed(scene.seed() + 7919u * static_cast<unsigned>(round));
    return scene;
  }

  // A pilot that did not complete: coarser and stiffer ones are then left out, the others end the
  // task.
  std::optional<TaskOutcome> run_round(int round) {
    std::size_t done = 0;
    for (auto at = scenes_.begin(); at != scenes_.end(); ++done) {
      const Pilot pilot = at->first;
      TaskOutcome outcome = run_pilot(pilot, round, static_cast<double>(done) / scenes_.size());
      pilot_cpu_s_ += outcome.result.cost().cpu_s();
      if (outcome.outcome == v1::TaskFinished::COMPLETE) {
        take(pilot, pilot_of_round(pilot, round).replicates(), outcome.result);
        ++at;
        continue;
      }
      if (pilot == Pilot::base || pilot == Pilot::fine_step || is_stop(outcome.outcome))
        return outcome;
      callbacks_.log("accuracy: pilot '" + to_string(pilot) + "' left out: " + outcome.message);
      for (auto& [name, means] : means_) means.erase(pilot);
      at = scenes_.erase(at);
    }
    return std::nullopt;
  }

  static bool is_stop(v1::TaskFinished::Outcome outcome) {
    return outcome == v1::TaskFinished::CANCELLED || outcome == v1::TaskFinished::RELEASED ||
           outcome == v1::TaskFinished::TIMED_OUT;
  }

  TaskOutcome run_pilot(Pilot pilot, int round, double share_done) {
    TaskSpec spec = spec_;
    spec.scene = pilot_of_round(pilot, round);
    spec.scene.clear_accuracy();
    spec.result_path.clear();
    spec.filling_key.clear();  // other steps make other beds
    if (spec.time_limit_s > 0)
      spec.time_limit_s = std::max(1e-3, spec.time_limit_s - timer_.wall_s());
    TaskCallbacks callbacks = callbacks_;
    callbacks.progress = [&](v1::Progress progress) {
      progress.set_fraction(kPilotProgress * (share_done + progress.fraction() / scenes_.size()));
      progress.set_phase("pilot: " + to_string(pilot));
      callbacks_.progress(progress);
    };
    callbacks_.log("accuracy: pilot '" + to_string(pilot) + "', " +
                   std::to_string(spec.scene.replicates()) + " replicates");
    return run_task(spec, factory_, callbacks, stop_, files_);
  }

  void take(Pilot pilot, unsigned replicates, const v1::Result& result) {
    for (const auto& [name, quantity] : result.values()) {
      if (!quantity.has_value() || !quantity.has_error()) continue;
      LevelMean& level = means_[name][pilot];
      level = pooled(level, level_of(quantity.value(), quantity.error(), replicates));
    }
    if (pilot == Pilot::base) {
      base_cpu_s_ += result.cost().cpu_s();
      base_runs_ += replicates;
    }
  }

  std::map<Step, double> costs() const;
  bool another_round_pays() const {
    return budget_s() == 0 || 2 * pilot_cpu_s_ < kPilotShare * budget_s();
  }

  // ---- main run

  unsigned affordable_replicates() const;
  TaskOutcome run_main();
  ErrorParts parts_of(const PilotMeans& means, unsigned replicates) const;
  void note_choice(unsigned replicates, TaskSpec& spec) const;
  TaskOutcome unknown_observable() const {
    TaskOutcome outcome;
    outcome.outcome = v1::TaskFinished::ERROR;
    outcome.message = "accuracy.observable: this scene gives no " + observable() + ", but";
    for (const auto& [name, means] : means_) outcome.message += " " + name;
    return outcome;
  }

  const TaskSpec& spec_;
  const SimulationFactory& factory_;
  const TaskCallbacks& callbacks_;
  const StopSignal& stop_;
  storage::FileSystem& files_;

  CostTimer timer_;
  std::map<Pilot, v1::Scene> scenes_;
  std::map<std::string, PilotMeans> means_;  // by observable
  Choice choice_;
  double pilot_cpu_s_ = 0;
  double base_cpu_s_ = 0;  // of the pilots as asked for
  unsigned base_runs_ = 0;
};

// By the shipped price list, so that every host chooses the same.
std::map<Step, double> AccuracyRun::costs() const {
  const auto cost_of = [&](const v1::Scene& scene) {
    v1::Scene single = scene;
    single.set_replicates(1);
    return predict_cost(single, Calibration()).cpu_s.value;
  };
  const double unit = cost_of(scenes_.at(Pilot::base));
  std::map<Step, double> costs{{Step::base, 1}};
  if (!scenes_.contains(Pilot::coarse_step)) return costs;  // the step is the user's
  costs[Step::fine] = cost_of(scenes_.at(Pilot::fine_step)) / unit;
  costs[Step::coarse] = cost_of(scenes_.at(Pilot::coarse_step)) / unit;
  return costs;
}

// Fewer replicates than chosen where the budget is spent before.
unsigned AccuracyRun::affordable_replicates() const {
  if (budget_s() == 0) return choice_.replicates;
  const double one_s = base_cpu_s_ / base_runs_ * choice_.cost / choice_.replicates;
  const double left_s = budget_s() - pilot_cpu_s_;
  const auto fit = static_cast<unsigned>(std::max(0.0, left_s / one_s));
  return std::clamp(fit, 2u, std::max(2u, choice_.replicates));
}

TaskOutcome AccuracyRun::run_main() {
  TaskSpec spec = spec_;
  const Pilot pilot = choice_.step == Step::fine     ? Pilot::fine_step
                      : choice_.step == Step::coarse ? Pilot::coarse_step
                                                     : Pilot::base;
  spec.scene = scenes_.at(pilot);
  const unsigned affordable = affordable_replicates();
  spec.scene.set_replicates(affordable);
  spec.variant = "step " + std::to_string(step_factor(choice_.step)) + ", " +
                 std::to_string(affordable) + " replicates";
  if (pilot != Pilot::base) spec.filling_key.clear();
  for (const auto& [name, means] : means_)
    if (means.contains(Pilot::base) && means.contains(Pilot::fine_step))
      spec.error_parts[name] = parts_of(means, affordable);
  spec.earlier_cpu_s = pilot_cpu_s_;
  spec.earlier_wall_s = timer_.wall_s();
  note_choice(affordable, spec);
  callbacks_.log("accuracy: main run, " + spec.variant);
  TaskCallbacks callbacks = callbacks_;
  callbacks.progress = [&](v1::Progress progress) {
    progress.set_fraction(kPilotProgress + (1 - kPilotProgress) * progress.fraction());
    callbacks_.progress(progress);
  };
  return run_task(spec, factory_, callbacks, stop_, files_);
}

ErrorParts AccuracyRun::parts_of(const PilotMeans& means, unsigned replicates) const {
  ErrorParts parts = error_parts(means, choice_.step, stiffness_ratio(spec_.scene));
  parts.sampling = spread_of(means).of_mean(replicates);
  return parts;
}

void AccuracyRun::note_choice(unsigned replicates, TaskSpec& spec) const {
  const PilotMeans& means = means_.at(observable());
  const double scale = std::abs(means.at(Pilot::base).mean);
  if (scale == 0) {
    const std::string why = observable() + " is 0, which has no relative error";
    spec.decisions.push_back(decision("replicates", replicates, why));
    spec.warnings.push_back("accuracy " + percent(target()) + " of " + why +
                            ": ask for that of another observable");
    return;
  }
  const ErrorParts& parts = spec.error_parts.at(observable());
  const double sampling = spread_of(means).of_mean(replicates);
  const double expected = combined(parts, sampling) / scale;
  const std::string of_parts =
      "expected error of " + observable() + " " + percent(expected) + " (discretisation " +
      percent(parts.discretisation / scale) + ", stiffness " + percent(parts.stiffness / scale) +
      ", solver " + percent(parts.solver / scale) + ", sampling " + percent(sampling / scale) + ")";
  const bool chute = spec.scene.has_chute();
  spec.decisions.push_back(decision(
      chute ? "chute.time_step_s" : "discharge.time_step_s",
      chute ? spec.scene.chute().time_step_s() : spec.scene.discharge().time_step_s(), of_parts));
  spec.decisions.push_back(decision("replicates", replicates, of_parts));
  if (expected <= target()) return;
  const double largest_fixed = combined(parts, 0) / scale;
  std::string advice;
  if (replicates < choice_.replicates && choice_.meets)
    advice = "a budget_s of about " +
             std::to_string(
                 static_cast<int>(pilot_cpu_s_ + base_cpu_s_ / base_runs_ * choice_.cost + 1)) +
             " would meet it";
  else if (largest_fixed > target())
    advice = "a target of " + percent(1.1 * largest_fixed) +
             " could be met with more replicates, or a smaller time step and a stiffer penalty";
  else
    advice = "more replicates could meet it";
  spec.warnings.push_back("accuracy " + percent(target()) + " of " + observable() +
                          " is not reached: " + of_parts + "; " + advice);
}

}  // namespace

TaskOutcome run_request(const TaskSpec& spec, const SimulationFactory& factory,
                        const TaskCallbacks& callbacks, const StopSignal& stop,
                        storage::FileSystem& files) {
  if (!spec.scene.accuracy().has_target()) return run_task(spec, factory, callbacks, stop, files);
  return AccuracyRun(spec, factory, callbacks, stop, files).execute();
}

}  // namespace granary::run
