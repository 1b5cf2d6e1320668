// granary price: what accuracy costs. Runs the ladders as a study, prints error against seconds and
// memory with the knee marked; -o FILE.svg draws it.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>

#include "client/commands/catalogue.h"
#include "client/commands/duration.h"
#include "client/commands/query_rows.h"
#include "client/commands/study_request.h"
#include "client/render/price_plot.h"

namespace granary::commands {
namespace {

using render::Json;

struct PriceOptions {
  SubmissionOptions submission;
  std::vector<std::string> observables;
  std::vector<std::string> ladders;
  std::uint32_t rungs = 0;
  std::uint32_t replicates = 0;
  double ratio = 0;
  std::optional<double> target;
  std::string budget;
};

const v1::Quantity* figure(const v1::Study& study, const std::string& key) {
  const auto found = study.summary().figures().find(key);
  return found == study.summary().figures().end() ? nullptr : &found->second;
}

// "chute.time_step_s=1e-05" -> its path and its value.
std::string path_of(const std::string& rung) {
  return rung.substr(0, rung.rfind('='));
}
std::string value_of(const std::string& rung) {
  return rung.substr(rung.rfind('=') + 1);
}

bool is_knee(const v1::Study& study, const std::string& rung) {
  const v1::Quantity* knee = figure(study, "knee|" + path_of(rung));
  return knee != nullptr &&
         std::abs(std::stod(value_of(rung)) - knee->value()) <= 1e-5 * std::abs(knee->value());
}

std::string verdict_of(const v1::Study& study, const std::string& rung,
                       const std::string& observable) {
  if (path_of(rung) == "replicates") return "sampling";
  const v1::Quantity* bias = figure(study, "bias|" + rung + "|" + observable);
  if (bias == nullptr) return "";
  const v1::Quantity* order = figure(study, "order|" + path_of(rung) + "|" + observable);
  if (order != nullptr && order->error_basis() == "screening")
    return "screening, " + bias->error_basis();
  if (order == nullptr || !order->has_value()) return bias->error_basis();
  char text[48];
  std::snprintf(text, sizeof text, "%s, order %.2g", bias->error_basis().c_str(), order->value());
  return text;
}

Json value_or_null(const v1::Quantity* quantity) {
  return quantity != nullptr && quantity->has_value() ? Json(quantity->value()) : Json(nullptr);
}

render::Table price_table(const v1::Study& study, const render::Table& points) {
  render::Table table{{"setting", "rung", "observable", "value", "error", "relative_error", "bias",
                       "verdict", "cpu_s", "memory_bytes", "ledger_remainder", "knee", "job"},
                      {}};
  for (const auto& point : points.rows) {
    const std::string rung = point[0], observable = point[1];
    const Json relative = point[2].is_number() && point[3].is_number() && double(point[2]) != 0
                              ? Json(double(point[3]) / std::abs(double(point[2])))
                              : Json(nullptr);
    table.rows.push_back({path_of(rung), std::stod(value_of(rung)), observable, point[2], point[3],
                          relative, value_or_null(figure(study, "bias|" + rung + "|" + observable)),
                          verdict_of(study, rung, observable), point[4],
                          value_or_null(figure(study, "memory|" + rung)),
                          value_or_null(figure(study, "remainder|" + rung)), is_knee(study, rung),
                          point[5]});
  }
  return table;
}

// One line per ladder, for the first observable.
std::vector<render::PricePlotLine> plot_lines(const render::Table& table) {
  std::vector<render::PricePlotLine> lines;
  for (const auto& row : table.rows) {
    if (row[2] != table.rows.front()[2] || !row[5].is_number() || !row[8].is_number()) continue;
    const std::string setting = row[0];
    const std::string name = setting.substr(setting.rfind('.') + 1);
    if (lines.empty() || lines.back().name != name) lines.push_back({name, {}});
    char label[32];
    std::snprintf(label, sizeof label, "%.3g", double(row[1]));
    lines.back().points.push_back({double(row[8]), double(row[5]), label, bool(row[11])});
  }
  return lines;
}

Status draw(const std::string& file, const std::string& scene, const render::Table& table) {
  if (table.rows.empty()) return Done{};
  const std::string observable = table.rows.front()[2];
  std::ofstream out(file, std::ios::binary);
  out << render::price_plot_svg(
      "What accuracy of " + observable + " costs: " + std::filesystem::path(scene).stem().string(),
      plot_lines(table));
  if (out.flush()) return Done{};
  return Error{ErrorCode::invalid_argument, "cannot write " + file, ""};
}

void say_verdicts(Context& context, const v1::Study& study) {
  context.say(study.summary().verdict());
  for (const auto& [key, quantity] : study.summary().figures()) {
    if (key.rfind("limit|", 0) != 0) continue;
    char text[96];
    std::snprintf(text, sizeof text, "%.6g +- %.2g", quantity.value(), quantity.error());
    context.detail(key + " = " + text);
  }
}

Status fill_in(v1::Price& price, const PriceOptions& options) {
  for (const std::string& name : options.observables) price.add_observable(name);
  for (const std::string& path : options.ladders) price.add_ladder(path);
  if (options.rungs > 0) price.set_rungs(options.rungs);
  if (options.replicates > 0) price.set_replicates(options.replicates);
  if (options.ratio > 0) price.set_ratio(options.ratio);
  if (options.target) price.set_target(*options.target);
  if (options.budget.empty()) return Done{};
  auto budget_s = parse_duration_s(options.budget);
  if (!budget_s)
    return Error{ErrorCode::invalid_argument, "--budget " + budget_s.error().message, ""};
  price.set_budget_s(*budget_s);
  return Done{};
}

Outcome price(Context& context, const PriceOptions& options) {
  auto request = study_request(context, options.submission);
  if (!request) return request.error();
  if (Status filled = fill_in(*request->mutable_spec()->mutable_price(), options); !filled)
    return filled.error();
  auto study = run_study(context, std::move(*request));
  if (!study) return study.error();
  if (!*study) return ExitCode::interrupted;
  auto points = query_rows(context,
                           "SELECT rung, observable, value, error, cpu_s, job FROM price "
                           "WHERE study = '" +
                               (*study)->name() + "'");
  if (!points) return points.error();
  const render::Table table = price_table(**study, *points);
  say_verdicts(context, **study);
  std::cout << render::render_rows(table, context.format(), render::JsonShape::array);
  std::cout.flush();
  if (!context.options().output.empty())
    if (Status drawn = draw(context.options().output, options.submission.scenes.front(), table);
        !drawn)
      return drawn.error();
  return (*study)->state() == v1::Study::COMPLETE && !table.rows.empty() ? ExitCode::ok
                                                                         : ExitCode::job_failed;
}

}  // namespace

void add_price(CommandLine& line) {
  auto options = std::make_shared<PriceOptions>();
  CLI::App& verb =
      line.verb("price", "What accuracy costs: error against CPU seconds over a ladder of settings",
                "granary price scene.txtpb --observable f1_m --replicates 6 -o price.svg");
  add_scene_options(verb, options->submission, false);
  add_submission_options(verb, options->submission);
  verb.add_option("--observable", options->observables, "a key of `values` (repeatable)")
      ->allow_extra_args(false);
  verb.add_option("--ladder", options->ladders, "a setting to climb, by path (repeatable)")
      ->allow_extra_args(false)
      ->type_name("PATH");
  verb.add_option("--rungs", options->rungs, "per ladder")->check(CLI::Range(2, 12));
  verb.add_option("--ratio", options->ratio, "of the setting between two rungs");
  verb.add_option("--replicates", options->replicates, "per rung (default 4)")
      ->check(CLI::Range(2, 100));
  verb.add_option("--target", options->target,
                  "relative error, e.g. 0.01: a ladder in which the scene meets it is climbed no "
                  "further")
      ->type_name("SHARE");
  verb.add_option("--budget", options->budget,
                  "CPU time of the whole study, e.g. 10m: finer rungs that do not fit are left out "
                  "(the scene and its coarser rungs always run)")
      ->type_name("DURATION");
  line.on(verb, [options](Context& context) { return price(context, *options); });
}

}  // namespace granary::commands
