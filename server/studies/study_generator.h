// The one interface between a study and what decides its trials: ask for scenes, tell what became
// of them. A generator is pure policy (no clock, no database, no threads) and its whole state is
// data.
//
// Rules that make a study continue after a crash as if nothing had happened:
//  - outcomes are told in the order of trial numbers, whatever order the jobs ended in;
//  - which trials are proposed may depend on the spec, on what has been told and on random numbers
//  that
//    are part of save(), never on time, on `limit` or on when ask() is called: ask(1) twice
//    proposes what ask(2) proposes;
//  - restore(save()) continues with the same proposals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "granary/v1/job.pb.h"
#include "granary/v1/scene.pb.h"
#include "granary/v1/study.pb.h"
#include "proto/contract/result.h"

namespace granary::server {

struct TrialProposal {
  v1::Scene scene;              // as a user would submit it
  std::string label;            // for people: "rotation_rad_per_s=9"
  std::string role;             // why: "grid", "start", "bracket", "replicate", ...
  std::uint32_t candidate = 0;  // 0 = its own; trials of one candidate differ in the seed
  std::map<std::string, std::string> inputs;  // scene path -> value as text
};

// What became of a trial. Anything but COMPLETE is recorded and must not stop a study.
struct TrialOutcome {
  v1::JobState state = v1::ERROR;  // COMPLETE, ERROR, UNSTABLE or CANCELLED
  std::string job;                 // "jobs/17"; empty when the scene was refused
  std::string error;
  v1::Result result;  // values with errors and costs; empty unless complete
};

// What the generator makes of an outcome; kept with the trial.
struct TrialJudgement {
  std::optional<double> objective;
  std::optional<double> objective_error;  // half-width of the 95 % interval
  std::optional<bool> feasible;
};

// Rows of the views `price`, `effects` and `pareto`: what a study has found so far, replaced as a
// whole.
struct PricePoint {
  std::string job;  // "jobs/17"
  std::string rung;
  std::string observable;
  std::optional<double> value, error, cpu_s;
};
struct EffectDelta {
  std::string effect;
  std::string observable;
  std::optional<double> delta, error, cpu_ratio;
};
struct Findings {
  std::vector<PricePoint> price;
  std::vector<EffectDelta> effects;
  std::vector<std::uint32_t> pareto;  // trial numbers
};

class StudyGenerator {
 public:
  virtual ~StudyGenerator() = default;

  // At most `limit` proposals; fewer, or none, when the next ones depend on outcomes not yet told.
  virtual std::vector<TrialProposal> ask(std::size_t limit) = 0;
  // `trial` counts proposals from 1; every proposal is told exactly once, in order.
  virtual TrialJudgement tell(std::uint32_t trial, const TrialOutcome& outcome) = 0;
  // Nothing will be proposed any more (what was proposed may still be running).
  virtual bool done() const = 0;

  virtual std::uint32_t planned() const = 0;  // trials in all; 0 = not known
  virtual v1::StudySummary summary() const = 0;
  // Asked after each tell; nothing = as before.
  virtual std::optional<Findings> findings() const { return {}; }

  // A new total; FAILED_PRECONDITION for studies with a fixed plan.
  virtual Status extend(std::uint32_t budget);

  virtual std::string save() const = 0;
  // Throws std::runtime_error on bytes that are not its own.
  virtual void restore(const std::string& bytes) = 0;
};

// A fresh generator, or what is wrong with the spec (INVALID_ARGUMENT with the field path).
Result<std::unique_ptr<StudyGenerator>> make_generator(const v1::StudySpec& spec);

// "sweep", "optimize", "price", "ablate" or "".
std::string_view kind_of(const v1::StudySpec& spec);

// What every generator does to make a trial: settings on a copy of the base scene.
Result<v1::Scene> scene_with(const v1::Scene& base,
                             const std::map<std::string, std::string>& inputs);
// "rotation_rad_per_s=9 count=200": last parts of the paths.
std::string label_of(const std::map<std::string, std::string>& inputs);

}  // namespace granary::server
