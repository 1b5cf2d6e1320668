#include "server/studies/optimize_settings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "proto/contract/field_path.h"
#include "proto/contract/resolve.h"
#include "server/studies/optimize.h"

namespace granary::server {
namespace {

Error wrong(const std::string& field, const std::string& what) {
  return {ErrorCode::invalid_argument, "optimize." + field + ": " + what, "optimize." + field};
}

std::string at(const char* list, int index) {
  return std::string(list) + "[" + std::to_string(index) + "]";
}

std::string number_text(double value, bool whole) {
  char text[32];
  std::snprintf(text, sizeof text, whole ? "%.0f" : "%.9g", value);
  return text;
}

Status check_variables(const v1::Optimize& settings) {
  if (settings.vary_size() == 0) return wrong("vary", "is empty: nothing to optimize");
  for (int i = 0; i < settings.vary_size(); ++i) {
    const auto& variable = settings.vary(i);
    if (!variable.has_minimum() || !variable.has_maximum())
      return wrong(at("vary", i), "needs minimum and maximum");
    if (!std::isfinite(variable.minimum()) || !std::isfinite(variable.maximum()) ||
        variable.minimum() >= variable.maximum())
      return wrong(at("vary", i) + ".minimum", "must be below maximum");
    for (int other = 0; other < i; ++other)
      if (settings.vary(other).path() == variable.path())
        return wrong(at("vary", i) + ".path", variable.path() + " is varied twice");
  }
  return Done{};
}

Status check_objective(const v1::Optimize& settings) {
  if (settings.objective_size() == 0) return wrong("objective", "is empty: nothing to aim at");
  for (int i = 0; i < settings.objective_size(); ++i) {
    const auto& term = settings.objective(i);
    if (term.value().empty()) return wrong(at("objective", i) + ".value", "is empty");
    if (term.has_weight() && !(term.weight() >= 0))
      return wrong(at("objective", i) + ".weight", "must be >= 0 (goal: MINIMISE turns it round)");
  }
  for (int i = 0; i < settings.constraint_size(); ++i) {
    const auto& constraint = settings.constraint(i);
    if (constraint.value().empty()) return wrong(at("constraint", i) + ".value", "is empty");
    if (!constraint.has_minimum() && !constraint.has_maximum())
      return wrong(at("constraint", i), "needs a minimum or a maximum");
  }
  return Done{};
}

Status check_numbers(const v1::Optimize& settings) {
  if (settings.budget() < 1 || settings.budget() > kMaxOptimizeTrials)
    return wrong("budget", "must be 1 to " + std::to_string(kMaxOptimizeTrials) + " trials");
  const bool nsga = settings.method() == v1::Optimize::NSGA_II;
  if (nsga && settings.objective_size() < 2)
    return wrong("objective", "NSGA_II needs two terms or more");
  if (nsga && (settings.population() < 8 || settings.population() % 4 != 0))
    return wrong("population", "NSGA_II needs a multiple of 4, 8 or more");
  if (settings.method() == v1::Optimize::CMA_ES && settings.population() < 5)
    return wrong("population", "CMA_ES needs 5 or more");
  if (settings.population() < 1 || settings.population() > 10'000)
    return wrong("population", "must be 1 to 10000");
  if (settings.gradual_deformation().line_evaluations() < 2)
    return wrong("gradual_deformation.line_evaluations", "must be 2 or more");
  if (settings.noise().replicates() < 1 ||
      settings.noise().replicates_max() < settings.noise().replicates())
    return wrong("noise.replicates", "must be 1 or more, and at most replicates_max");
  const double promote = settings.coarse().promote();
  if (settings.has_coarse() && !(promote > 0 && promote <= 1))
    return wrong("coarse.promote", "must be > 0 and <= 1");
  return Done{};
}

std::uint32_t default_population(const v1::Optimize& settings) {
  if (settings.method() == v1::Optimize::NSGA_II) return 16;
  // Hansen's default for CMA-ES, 4 + 3 ln n, at least what pagmo accepts.
  const double hansen = 4 + 3 * std::log(static_cast<double>(std::max(settings.vary_size(), 1)));
  return std::max(6u, static_cast<std::uint32_t>(hansen));
}

void fill_defaults(v1::StudySpec& spec) {
  v1::Optimize& settings = *spec.mutable_optimize();
  if (!settings.has_population()) settings.set_population(default_population(settings));
  auto& line = *settings.mutable_gradual_deformation();
  if (!line.has_line_evaluations()) line.set_line_evaluations(6);
  if (!line.has_parallel()) line.set_parallel(2);
  auto& noise = *settings.mutable_noise();
  if (!noise.has_replicates()) noise.set_replicates(1);
  if (!noise.has_replicates_max()) noise.set_replicates_max(noise.replicates());
  if (settings.has_coarse() && !settings.coarse().has_promote())
    settings.mutable_coarse()->set_promote(0.25);
  // An optimiser could otherwise win by shrinking the bucket (PHYSICS E.3).
  const auto is_fill = [](const auto& c) { return c.value() == "fill_ratio"; };
  if (spec.scene().has_discharge() && !spec.scene().discharge().no_bucket() &&
      std::none_of(settings.constraint().begin(), settings.constraint().end(), is_fill)) {
    auto& constraint = *settings.add_constraint();
    constraint.set_value("fill_ratio");
    constraint.set_minimum(0.95);
  }
}

std::map<std::string, double> numbers_of(const v1::Scene& scene) {
  std::map<std::string, double> numbers;
  for_each_set_scalar(
      scene, [&](const std::string& path, const auto& message, const auto& field, int index) {
        numbers[path] = scalar_number(message, field, index);
      });
  return numbers;
}

// Sets OptimizeSettings::start and whole_numbers; every end of every range must be a value of its
// field.
Status place_variables(OptimizeSettings& settings) {
  const v1::Scene& base = settings.spec.scene();
  auto resolved = resolve(base);
  if (!resolved) return resolved.error();
  const auto numbers = numbers_of(resolved->scene);
  for (int i = 0; i < settings.optimize().vary_size(); ++i) {
    const auto& variable = settings.optimize().vary(i);
    v1::Scene probe = base;
    const bool whole = !set_field(probe, variable.path(), "0.5").ok();
    settings.whole_numbers.push_back(whole);
    for (const double end : {variable.minimum(), variable.maximum()})
      if (Status set = set_field(probe, variable.path(), number_text(end, whole)); !set)
        return wrong(at("vary", i) + ".path", set.error().message);
    const auto known = numbers.find(variable.path());
    double start = (variable.minimum() + variable.maximum()) / 2;
    if (known != numbers.end() && std::isfinite(known->second)) start = known->second;
    if (variable.has_start()) start = variable.start();
    const double share = (start - variable.minimum()) / (variable.maximum() - variable.minimum());
    settings.start.push_back(std::clamp(share, 0.0, 1.0));
  }
  return Done{};
}

Status check_scenes(const OptimizeSettings& settings) {
  auto start = scene_with(settings.spec.scene(), settings.inputs_at(settings.start));
  if (!start) return start.error();
  if (auto resolved = resolve(*start); !resolved) return resolved.error();
  for (int i = 0; i < settings.optimize().coarse().set_size(); ++i) {
    const std::string& text = settings.optimize().coarse().set(i);
    const auto equals = text.find('=');
    v1::Scene probe = settings.spec.scene();
    if (equals == std::string::npos)
      return wrong(at("coarse.set", i), "'" + text + "' is not of the form path=value");
    if (Status set = set_field(probe, text.substr(0, equals), text.substr(equals + 1)); !set)
      return wrong(at("coarse.set", i), set.error().message);
  }
  return Done{};
}

}  // namespace

SearchSetup OptimizeSettings::search_setup() const {
  return {start, static_cast<std::size_t>(optimize().objective_size()), optimize().population(),
          spec.has_seed() ? spec.seed() : 1};
}

std::map<std::string, std::string> OptimizeSettings::inputs_at(const Point& point) const {
  std::map<std::string, std::string> inputs;
  for (std::size_t i = 0; i < point.size(); ++i) {
    const auto& variable = optimize().vary(static_cast<int>(i));
    const double share = std::clamp(point[i], 0.0, 1.0);
    inputs[variable.path()] = number_text(
        variable.minimum() + share * (variable.maximum() - variable.minimum()), whole_numbers[i]);
  }
  return inputs;
}

Result<OptimizeSettings> read_settings(const v1::StudySpec& spec) {
  OptimizeSettings settings;
  settings.spec = spec;
  fill_defaults(settings.spec);
  for (const auto& check : {check_variables, check_objective, check_numbers})
    if (Status status = check(settings.optimize()); !status) return status.error();
  if (Status status = place_variables(settings); !status) return status.error();
  if (Status status = check_scenes(settings); !status) return status.error();
  return settings;
}

}  // namespace granary::server
