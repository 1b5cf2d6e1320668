// granary check: the plan of a scene, without a server: what it will cost, which effects run and
// why, every setting and who chose it.
#include <cmath>
#include <cstdio>

#include "client/commands/catalogue.h"
#include "client/commands/duration.h"
#include "client/commands/submission.h"
#include "proto/contract/cost_model.h"
#include "proto/contract/scene_rules.h"

namespace granary::commands {
namespace {

using render::Json;

render::Table effects_table(const ResolvedScene& resolved) {
  render::Table table{
      {"effect", "on", "number", "threshold", "omitted_error", "chosen_by", "reason"}, {}};
  const auto number = [](bool known, double value) {
    return known ? render::number_or_null(value) : Json(nullptr);
  };
  for (const auto& [name, effect] : resolved.effects)
    table.rows.push_back({name, effect.on(), number(effect.has_number(), effect.number()),
                          number(effect.has_threshold(), effect.threshold()),
                          number(effect.has_omitted_error(), effect.omitted_error()),
                          effect.chosen_by(), effect.reason()});
  return table;
}

render::Table settings_table(const ResolvedScene& resolved) {
  render::Table table{{"path", "value", "chosen_by", "evidence"}, {}};
  for (const auto& decision : resolved.decisions)
    table.rows.push_back(
        {decision.path(), decision.value(), decision.chosen_by(), decision.evidence()});
  return table;
}

Json rows_json(const render::Table& table) {
  Json array = Json::array();
  for (std::size_t i = 0; i < table.rows.size(); ++i) array.push_back(render::row_object(table, i));
  return array;
}

Json effects_json(const render::Table& table) {
  Json effects = Json::object();
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    Json effect = render::row_object(table, i);
    const std::string name = effect["effect"];
    effect.erase("effect");
    effects[name] = effect;
  }
  return effects;
}

struct CheckOptions {
  SubmissionOptions submission;
  std::string budget;
};

// What check says about cost; the budget's part only when there is one.
struct Prediction {
  CostEstimate cost;
  std::optional<double> budget_s;
  BudgetChoice choice;
};

Prediction predict(const LoadedScene& loaded, std::optional<double> budget_s) {
  const Calibration calibration = Calibration::load();
  Prediction prediction{predict_cost(loaded.resolved.scene, calibration), budget_s, {}};
  if (budget_s) prediction.choice = fit_budget(loaded.resolved.scene, calibration, *budget_s);
  return prediction;
}

Json estimate_json(const Estimate& estimate) {
  return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
}

template <typename T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json cost_json(const Prediction& prediction) {
  const CostEstimate& cost = prediction.cost;
  return {{"cpu_s", estimate_json(cost.cpu_s)},
          {"memory_bytes", estimate_json(cost.memory_bytes)},
          {"disk_bytes", estimate_json(cost.disk_bytes)},
          {"steps", cost.steps},
          {"particle_steps", cost.particle_steps},
          {"ns_per_particle_step", cost.ns_per_particle_step},
          {"basis", cost.basis}};
}

Json budget_json(const Prediction& prediction) {
  if (!prediction.budget_s) return nullptr;
  const BudgetChoice& choice = prediction.choice;
  return {{"budget_s", *prediction.budget_s},
          {"fits", choice.fits},
          {"replicates", optional_json(choice.replicates)},
          {"time_step_s", optional_json(choice.time_step_s)},
          {"particles", optional_json(choice.particles)},
          {"duration_s", optional_json(choice.duration_s)}};
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string seconds_text(double seconds) {
  if (seconds < 120) return number_text(seconds) + " s";
  if (seconds < 7200) return number_text(seconds / 60) + " min";
  return number_text(seconds / 3600) + " h";
}

std::string bytes_text(double bytes) {
  return number_text(bytes / 1e6) + " MB";
}

template <typename Format>
std::string interval_text(const Estimate& estimate, Format format) {
  return format(estimate.value) + " (" + format(estimate.low) + " .. " + format(estimate.high) +
         ")";
}

std::string budget_text(const Prediction& prediction) {
  if (!prediction.budget_s) return "";
  const BudgetChoice& choice = prediction.choice;
  std::string text = "within " + seconds_text(*prediction.budget_s) + " of CPU, surely: " +
                     (choice.fits ? "fits as it is" : "does not fit as it is");
  text += "; one of these at a time: ";
  std::string parts;
  const auto add = [&](const std::string& part) { parts += (parts.empty() ? "" : ", ") + part; };
  if (choice.replicates) add("replicates <= " + std::to_string(*choice.replicates));
  if (choice.time_step_s) add("time_step_s >= " + number_text(*choice.time_step_s));
  if (choice.particles) add("count <= " + std::to_string(*choice.particles));
  if (choice.duration_s) add("duration_s <= " + number_text(*choice.duration_s));
  return text + (parts.empty() ? "nothing" : parts) + "\n";
}

std::string cost_text(const Prediction& prediction) {
  const CostEstimate& cost = prediction.cost;
  return "predicted: " + interval_text(cost.cpu_s, seconds_text) + " of CPU, " +
         interval_text(cost.memory_bytes, bytes_text) + " of memory, " +
         interval_text(cost.disk_bytes, bytes_text) + " on disk\n           " +
         number_text(cost.particle_steps) + " particle steps at " +
         number_text(cost.ns_per_particle_step) + " ns; " + cost.basis + "\n" +
         budget_text(prediction);
}

std::string plan_json(const LoadedScene& loaded, const Prediction& prediction) {
  const Json plan = {{"scene", loaded.source},
                     {"kind", kind_of(loaded.resolved.scene)},
                     {"key", job_key(loaded.resolved.scene)},
                     {"particles", prediction.cost.particles},
                     {"predicted", cost_json(prediction)},
                     {"budget", budget_json(prediction)},
                     {"effects", effects_json(effects_table(loaded.resolved))},
                     {"settings", rows_json(settings_table(loaded.resolved))},
                     {"warnings", loaded.resolved.warnings}};
  return render::compact(plan) + "\n";
}

std::string plan_text(const LoadedScene& loaded, const Prediction& prediction) {
  return loaded.source + ": valid " + std::string(kind_of(loaded.resolved.scene)) + ", " +
         std::to_string(prediction.cost.particles) + " particles\n" + cost_text(prediction) + "\n" +
         render::as_aligned_text(effects_table(loaded.resolved)) + "\n" +
         render::as_aligned_text(settings_table(loaded.resolved));
}

Outcome check(Context& context, const CheckOptions& options) {
  std::optional<double> budget_s;
  if (!options.budget.empty()) {
    auto seconds = parse_duration_s(options.budget);
    if (!seconds)
      return Error{ErrorCode::invalid_argument, "--budget " + seconds.error().message, ""};
    budget_s = *seconds;
  }
  auto scenes = load_scenes(options.submission);
  if (!scenes) return scenes.error();
  for (const LoadedScene& loaded : *scenes) {
    for (const std::string& warning : loaded.resolved.warnings)
      context.say(loaded.source + ": warning: " + warning);
    const Prediction prediction = predict(loaded, budget_s);
    const std::string text =
        context.format() == render::Format::json  ? plan_json(loaded, prediction)
        : context.format() == render::Format::csv ? render::as_csv(settings_table(loaded.resolved))
                                                  : plan_text(loaded, prediction);
    if (auto written = context.write(text); !written) return written.error();
  }
  return ExitCode::ok;
}

}  // namespace

void add_check(CommandLine& line) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App& verb =
      line.verb("check", "Validate a scene and print its plan and price; needs no server",
                "granary check scene.txtpb --set discharge.particles.count=4000");
  add_scene_options(verb, options->submission, true);
  verb.add_option("--budget", options->budget, "CPU time: what would fit into it, e.g. 10m")
      ->type_name("DURATION");
  line.on(verb, [options](Context& context) { return check(context, *options); });
}

}  // namespace granary::commands
