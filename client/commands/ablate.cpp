// granary ablate: what each effect contributes and costs, by pairs with and without it.
#include <cmath>

#include "client/commands/catalogue.h"
#include "client/commands/query_rows.h"
#include "client/commands/study_request.h"

namespace granary::commands {
namespace {

using render::Json;

struct AblateOptions {
  SubmissionOptions submission;
  std::vector<std::string> effects;
  std::vector<std::string> observables;
  std::uint32_t replicates = 0;
};

const v1::Quantity* figure(const v1::Study& study, const std::string& key) {
  const auto found = study.summary().figures().find(key);
  return found == study.summary().figures().end() ? nullptr : &found->second;
}

std::string verdict(const Json& delta, const Json& error) {
  if (!delta.is_number() || !error.is_number()) return "";
  if (double(delta) == 0 && double(error) == 0) return "none at all";
  return std::abs(double(delta)) > double(error) ? "shows" : "below noise";
}

render::Table ablate_table(const v1::Study& study, const render::Table& rows) {
  render::Table table{{"effect", "in_scene", "observable", "delta", "error", "relative",
                       "relative_error", "verdict", "cpu_ratio"},
                      {}};
  for (const auto& row : rows.rows) {
    const std::string effect = row[0], observable = row[1];
    const v1::Quantity* on = figure(study, "on|" + effect);
    const v1::Quantity* relative = figure(study, "relative|" + effect + "|" + observable);
    table.rows.push_back({effect, on != nullptr ? Json(on->value() > 0) : Json(nullptr), observable,
                          row[2], row[3], relative ? Json(relative->value()) : Json(nullptr),
                          relative ? Json(relative->error()) : Json(nullptr),
                          verdict(row[2], row[3]), row[4]});
  }
  for (const auto& [key, quantity] : study.summary().figures())
    if (key.rfind("unavailable|", 0) == 0)
      table.rows.push_back({key.substr(12), nullptr, "", nullptr, nullptr, nullptr, nullptr,
                            "not available: " + quantity.error_basis(), nullptr});
  return table;
}

Outcome ablate(Context& context, const AblateOptions& options) {
  auto request = study_request(context, options.submission);
  if (!request) return request.error();
  v1::Ablate& ablate = *request->mutable_spec()->mutable_ablate();
  for (const std::string& name : options.effects) ablate.add_effect(name);
  for (const std::string& name : options.observables) ablate.add_observable(name);
  if (options.replicates > 0) ablate.set_replicates(options.replicates);
  auto study = run_study(context, std::move(*request));
  if (!study) return study.error();
  if (!*study) return ExitCode::interrupted;
  auto rows = query_rows(context,
                         "SELECT effect, observable, delta, error, cpu_ratio FROM effects "
                         "WHERE study = '" +
                             (*study)->name() + "'");
  if (!rows) return rows.error();
  context.say((*study)->summary().verdict());
  if (auto written = context.write_rows(ablate_table(**study, *rows), render::JsonShape::array);
      !written)
    return written.error();
  return (*study)->state() == v1::Study::COMPLETE && !rows->rows.empty() ? ExitCode::ok
                                                                         : ExitCode::job_failed;
}

}  // namespace

void add_ablate(CommandLine& line) {
  auto options = std::make_shared<AblateOptions>();
  CLI::App& verb =
      line.verb("ablate", "What each effect contributes and costs: pairs with and without it",
                "granary ablate scene.txtpb --effect rotating_frame --effect "
                "chute.contact_pp.friction_coefficient=0");
  add_scene_options(verb, options->submission, false);
  add_submission_options(verb, options->submission);
  verb.add_option("--effect", options->effects,
                  "an effect, or path=value against the scene as it is (repeatable; default: all)")
      ->allow_extra_args(false);
  verb.add_option("--observable", options->observables, "a key of `values` (repeatable)")
      ->allow_extra_args(false);
  verb.add_option("--replicates", options->replicates, "per side of a pair (default 6)")
      ->check(CLI::Range(2, 100));
  line.on(verb, [options](Context& context) { return ablate(context, *options); });
}

}  // namespace granary::commands
