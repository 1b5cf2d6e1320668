#include "worker/run/accuracy_plan.h"

#include <algorithm>
#include <cmath>

namespace granary::run {
namespace {

constexpr double kPenaltyFactor = 10;   // error ~ 1 / K
constexpr double kStiffnessFactor = 4;  // error ~ k^-1/2, the step follows the contact time
constexpr double kToleranceFactor = 0.3;

bool is_users(const std::vector<v1::Decision>& decisions, const std::string& path) {
  return std::any_of(decisions.begin(), decisions.end(), [&](const v1::Decision& decision) {
    return decision.path() == path && decision.chosen_by() == "user";
  });
}

void scale_step(v1::Scene& scene, double factor) {
  if (scene.has_chute()) {
    v1::Chute& chute = *scene.mutable_chute();
    chute.set_time_step_s(chute.time_step_s() * factor);
    return;
  }
  v1::Discharge& discharge = *scene.mutable_discharge();
  discharge.set_time_step_s(discharge.time_step_s() * factor);
  discharge.set_filling_time_step_s(discharge.filling_time_step_s() * factor);
}

void stiffen(v1::Scene& scene) {
  if (scene.has_chute()) {
    for (v1::Contact* contact :
         {scene.mutable_chute()->mutable_contact_pp(), scene.mutable_chute()->mutable_contact_pw()})
      contact->set_normal_stiffness_n_per_m(contact->normal_stiffness_n_per_m() * kStiffnessFactor);
    return scale_step(scene, 1 / std::sqrt(kStiffnessFactor));
  }
  v1::Penalty& penalty = *scene.mutable_discharge()->mutable_penalty();
  penalty.set_stiffness_n_per_m(penalty.stiffness_n_per_m() * kPenaltyFactor);
}

double bound(const LevelMean& level, const LevelMean& finer, const Spread& spread, double extra) {
  const double seen = std::abs(level.mean - finer.mean);
  const double noise = spread.of_difference(level.count, finer.count);
  return extra * (seen > noise ? std::hypot(seen, noise) : noise);
}

}  // namespace

std::string to_string(Pilot pilot) {
  switch (pilot) {
    case Pilot::base:
      return "as asked for";
    case Pilot::fine_step:
      return "half the time step";
    case Pilot::coarse_step:
      return "twice the time step";
    case Pilot::stiff:
      return "stiffer contacts";
    case Pilot::tight:
      return "tighter solver";
  }
  return "";
}

// A stiffness that the user gives a chute is the material's, and not for us to doubt; a penalty is
// numerical whoever chose it.
std::optional<v1::Scene> pilot_scene(Pilot pilot, const v1::Scene& resolved,
                                     const std::vector<v1::Decision>& decisions) {
  v1::Scene scene = resolved;
  const char* kind = scene.has_chute() ? "chute" : "discharge";
  switch (pilot) {
    case Pilot::base:
      break;
    case Pilot::fine_step:
      scale_step(scene, step_factor(Step::fine));
      break;
    case Pilot::coarse_step:
      if (is_users(decisions, std::string(kind) + ".time_step_s")) return std::nullopt;
      scale_step(scene, step_factor(Step::coarse));
      break;
    case Pilot::stiff:
      if (scene.has_chute() && is_users(decisions, "chute.contact_pp.normal_stiffness_n_per_m"))
        return std::nullopt;
      stiffen(scene);
      break;
    case Pilot::tight:
      if (!scene.has_discharge()) return std::nullopt;
      scene.mutable_discharge()->mutable_solver()->set_tolerance(
          scene.discharge().solver().tolerance() * kToleranceFactor);
      break;
  }
  return scene;
}

LevelMean pooled(const LevelMean& a, const LevelMean& b) {
  if (a.count == 0) return b;
  if (b.count == 0) return a;
  const double n = a.count, m = b.count;
  const double mean = (n * a.mean + m * b.mean) / (n + m);
  const double squares = (n - 1) * a.deviation * a.deviation + (m - 1) * b.deviation * b.deviation +
                         n * (a.mean - mean) * (a.mean - mean) +
                         m * (b.mean - mean) * (b.mean - mean);
  return {mean, std::sqrt(squares / (n + m - 1)), a.count + b.count};
}

double Spread::of_mean(unsigned count) const {
  if (degrees == 0 || count == 0) return 0;
  return student_t_95(degrees) * deviation / std::sqrt(count);
}

double Spread::of_difference(unsigned count_a, unsigned count_b) const {
  if (degrees == 0 || count_a == 0 || count_b == 0) return 0;
  return student_t_95(degrees) * deviation * std::sqrt(1.0 / count_a + 1.0 / count_b);
}

Spread spread_of(const PilotMeans& means) {
  double squares = 0;
  unsigned degrees = 0;
  for (const auto& [pilot, level] : means) {
    if (level.count < 2) continue;
    squares += (level.count - 1) * level.deviation * level.deviation;
    degrees += level.count - 1;
  }
  return {degrees > 0 ? std::sqrt(squares / degrees) : 0, degrees};
}

double step_factor(Step step) {
  return step == Step::coarse ? 2 : step == Step::base ? 1 : 0.5;
}

namespace {

// Bias per unit of h, from all levels of the time step: mean = limit + slope h, h = 1 as asked for.
double step_bias(const PilotMeans& means, const Spread& spread) {
  const std::pair<Pilot, double> kLevels[] = {{Pilot::coarse_step, step_factor(Step::coarse)},
                                              {Pilot::base, step_factor(Step::base)},
                                              {Pilot::fine_step, step_factor(Step::fine)}};
  double n = 0, nh = 0, nm = 0, nhh = 0, nhm = 0;
  for (const auto& [pilot, h] : kLevels) {
    const auto level = means.find(pilot);
    if (level == means.end()) continue;
    const double count = level->second.count, mean = level->second.mean;
    n += count, nh += count * h, nm += count * mean;
    nhh += count * h * h, nhm += count * h * mean;
  }
  const double scatter = nhh - nh * nh / n;
  if (!(scatter > 0)) return 0;
  const double slope = std::abs(nhm - nh * nm / n) / scatter;
  const double noise = spread.of_mean(1) / std::sqrt(scatter);
  return slope > noise ? std::hypot(slope, noise) : noise;
}

}  // namespace

ErrorParts error_parts(const PilotMeans& means, Step step, double stiffness_ratio) {
  const Spread spread = spread_of(means);
  const auto base = means.find(Pilot::base);
  ErrorParts parts;
  if (base == means.end()) return parts;
  parts.discretisation = step_factor(step) * step_bias(means, spread);
  if (const auto stiff = means.find(Pilot::stiff); stiff != means.end())
    parts.stiffness =
        bound(base->second, stiff->second, spread, stiffness_ratio / (stiffness_ratio - 1));
  if (const auto tight = means.find(Pilot::tight); tight != means.end())
    parts.solver = bound(base->second, tight->second, spread, 1);
  return parts;
}

namespace {

// Fewest replicates whose sampling error leaves room for the other parts; kMostReplicates + 1:
// none.
unsigned replicates_for(const ErrorParts& parts, const Spread& spread, double tolerance) {
  const double left = tolerance * tolerance - std::pow(combined(parts, 0), 2);
  if (left <= 0) return kMostReplicates + 1;
  unsigned count = 2;
  while (count <= kMostReplicates && std::pow(spread.of_mean(count), 2) > left) ++count;
  return count;
}

}  // namespace

Choice choose(const PilotMeans& means, const std::map<Step, double>& costs, double target,
              double stiffness_ratio, std::optional<unsigned> fixed_replicates) {
  const Spread spread = spread_of(means);
  const double scale = std::abs(means.at(Pilot::base).mean);
  std::optional<Choice> best;
  for (const auto& [step, cost] : costs) {
    if (step == Step::coarse && !means.contains(Pilot::coarse_step)) continue;
    const ErrorParts parts = error_parts(means, step, stiffness_ratio);
    const unsigned wanted =
        fixed_replicates.value_or(replicates_for(parts, spread, target * scale));
    Choice choice;
    choice.step = step;
    choice.replicates = std::min(wanted, kMostReplicates);
    choice.error = combined(parts, spread.of_mean(choice.replicates)) / scale;
    choice.cost = cost * choice.replicates;
    choice.meets = scale > 0 && choice.error <= target * (1 + 1e-9);
    const bool better = !best || (choice.meets != best->meets ? choice.meets
                                  : choice.meets              ? choice.cost < best->cost
                                                              : choice.error < best->error);
    if (better) best = choice;
  }
  const double noise =
      spread.of_difference(means.at(Pilot::base).count, means.at(Pilot::fine_step).count);
  best->noise_limits = !best->meets && noise > 0.25 * target * scale;
  return *best;
}

}  // namespace granary::run
