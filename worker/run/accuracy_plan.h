// How a scene that asks for an accuracy gets there: which pilot runs say what its error consists
// of, and which setting is the cheapest that meets the target. Arithmetic only; accuracy_run.h runs
// the pilots.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "granary/v1/result.pb.h"
#include "granary/v1/scene.pb.h"
#include "proto/contract/ladder.h"
#include "worker/run/error_parts.h"

namespace granary::run {

enum class Pilot { base, fine_step, coarse_step, stiff, tight };
std::string to_string(Pilot pilot);

// The scene of a pilot, or nothing when the kind of scene, or what the user has fixed, leaves none.
std::optional<v1::Scene> pilot_scene(Pilot pilot, const v1::Scene& resolved,
                                     const std::vector<v1::Decision>& decisions);

// Of one observable, over all replicates of all pilots so far.
using PilotMeans = std::map<Pilot, LevelMean>;
LevelMean pooled(const LevelMean& a, const LevelMean& b);

// One standard deviation for all levels: settings change the mean, hardly the spread.
struct Spread {
  double deviation = 0;
  unsigned degrees = 0;
  // 95 % half-width of a mean of `count` runs; of a difference of two means.
  double of_mean(unsigned count) const;
  double of_difference(unsigned count_a, unsigned count_b) const;
};
Spread spread_of(const PilotMeans& means);

enum class Step { coarse, base, fine };
double step_factor(Step step);  // of the time step: 2, 1, 1/2

// Errors go with the time step as with 1 / K or k^-1/2 (PHYSICS D 1 to D 3); where no difference
// shows, what noise could hide is the bound.
ErrorParts error_parts(const PilotMeans& means, Step step, double stiffness_ratio);

struct Choice {
  Step step = Step::base;
  unsigned replicates = 2;
  double error = 0;  // expected, relative
  double cost = 0;   // of the main run, in units of one base run
  bool meets = false;
  bool noise_limits = false;  // more pilot replicates could lower the error
};
// The cheapest choice that meets the relative target, or the most accurate one when none does.
// `costs`: of one run at each step that may be chosen. At least `fixed_replicates` when the user
// has said so (and then exactly that many).
Choice choose(const PilotMeans& means, const std::map<Step, double>& costs, double target,
              double stiffness_ratio, std::optional<unsigned> fixed_replicates);

constexpr unsigned kMostReplicates = 64;

}  // namespace granary::run
