#include "client/commands/studies.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <iostream>
#include <map>

#include "client/session/interrupt.h"
#include "proto/contract/job_state.h"

namespace granary::commands {
namespace {

using google::protobuf::util::TimeUtil;
using render::Json;

constexpr std::string_view kPrefix = "studies/";

std::string state_text(v1::Study::State state) {
  std::string text = v1::Study::State_Name(state);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return text;
}

Json text_cell(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

Json number_cell(bool known, double value) {
  return known ? render::number_or_null(value) : Json(nullptr);
}

Json sorted_object(const google::protobuf::Map<std::string, std::string>& map) {
  Json object = Json::object();
  for (const auto& [key, value] : std::map<std::string, std::string>(map.begin(), map.end()))
    object[key] = value;
  return object;
}

std::map<std::string, v1::Quantity> sorted(
    const google::protobuf::Map<std::string, v1::Quantity>& map) {
  return {map.begin(), map.end()};
}

Json values_object(const v1::Trial& trial) {
  Json object = Json::object();
  for (const auto& [name, quantity] : sorted(trial.values()))
    object[name] = {{"value", number_cell(quantity.has_value(), quantity.value())},
                    {"error", number_cell(quantity.has_error(), quantity.error())}};
  return object;
}

std::vector<Json> full_row(const v1::Study& study) {
  const v1::StudySummary& summary = study.summary();
  return {study.name(),
          text_cell(study.spec().name()),
          study.kind(),
          state_text(study.state()),
          text_cell(study.owner()),
          TimeUtil::ToString(study.submitted()),
          study.has_ended() ? Json(TimeUtil::ToString(study.ended())) : Json(nullptr),
          study.planned() > 0 ? Json(study.planned()) : Json(nullptr),
          study.trials(),
          study.ended_trials(),
          study.failed_trials(),
          study.reused_trials(),
          summary.has_best_trial() ? Json(summary.best_trial()) : Json(nullptr),
          number_cell(summary.has_best_objective(), summary.best_objective()),
          number_cell(summary.has_best_objective_error(), summary.best_objective_error()),
          sorted_object(summary.best_inputs()),
          text_cell(summary.verdict()),
          text_cell(study.message())};
}

std::string progress_text(const v1::Study& study) {
  std::string text = std::to_string(study.ended_trials());
  if (study.planned() > 0) text += "/" + std::to_string(study.planned());
  text += " trials";
  if (study.reused_trials() > 0) text += ", " + std::to_string(study.reused_trials()) + " reused";
  if (study.failed_trials() > 0) text += ", " + std::to_string(study.failed_trials()) + " failed";
  return text;
}

std::vector<Json> brief_row(const v1::Study& study) {
  return {study.name(),
          text_cell(study.spec().name()),
          study.kind(),
          state_text(study.state()),
          progress_text(study),
          text_cell(study.message().empty() ? study.summary().verdict() : study.message())};
}

std::vector<Json> full_row(const v1::Trial& trial) {
  return {trial.study(),
          trial.number(),
          text_cell(trial.job()),
          to_string(trial.state()),
          trial.role(),
          trial.candidate(),
          sorted_object(trial.inputs()),
          number_cell(trial.has_objective(), trial.objective()),
          number_cell(trial.has_objective_error(), trial.objective_error()),
          trial.has_feasible() ? Json(trial.feasible()) : Json(nullptr),
          number_cell(trial.has_best_objective(), trial.best_objective()),
          trial.pareto(),
          values_object(trial),
          trial.cpu_s() > 0 ? Json(trial.cpu_s()) : Json(nullptr),
          trial.reused(),
          text_cell(trial.error())};
}

// For people: inputs by the last part of their path, and the first few values.
std::vector<std::string> value_columns(const std::vector<v1::Trial>& trials) {
  static const std::vector<std::string> kMain = {
      "f1_m",          "f2_m", "f3_percent", "f4_m", "mass_flow_kg_per_s", "exit_speed_m_per_s",
      "particle_count"};
  std::vector<std::string> columns;
  for (const std::string& name : kMain)
    if (std::any_of(trials.begin(), trials.end(),
                    [&](const v1::Trial& trial) { return trial.values().count(name) > 0; }))
      columns.push_back(name);
  return columns;
}

std::vector<std::string> input_columns(const std::vector<v1::Trial>& trials) {
  std::map<std::string, int> paths;
  for (const v1::Trial& trial : trials)
    for (const auto& [path, value] : trial.inputs()) paths[path] = 1;
  std::vector<std::string> columns;
  for (const auto& [path, one] : paths) columns.push_back(path);
  return columns;
}

Json value_cell(const v1::Trial& trial, const std::string& name) {
  const auto found = trial.values().find(name);
  if (found == trial.values().end()) return nullptr;
  return number_cell(found->second.has_value(), found->second.value());
}

render::Table brief_trials(const std::vector<v1::Trial>& trials) {
  const auto inputs = input_columns(trials);
  const auto values = value_columns(trials);
  const bool judged = std::any_of(trials.begin(), trials.end(),
                                  [](const v1::Trial& trial) { return trial.has_objective(); });
  render::Table table{{"trial", "job", "state"}, {}};
  for (const std::string& path : inputs) table.columns.push_back(path.substr(path.rfind('.') + 1));
  if (judged) table.columns.insert(table.columns.end(), {"objective", "+-", "best"});
  table.columns.insert(table.columns.end(), values.begin(), values.end());
  table.columns.push_back("error");
  for (const v1::Trial& trial : trials) {
    std::vector<Json> row = {
        trial.number(), text_cell(trial.job()),
        std::string(to_string(trial.state())) + (trial.reused() ? " (reused)" : "")};
    for (const std::string& path : inputs) {
      const auto found = trial.inputs().find(path);
      row.push_back(found == trial.inputs().end() ? Json(nullptr) : Json(found->second));
    }
    if (judged)
      row.insert(row.end(), {number_cell(trial.has_objective(), trial.objective()),
                             number_cell(trial.has_objective_error(), trial.objective_error()),
                             number_cell(trial.has_best_objective(), trial.best_objective())});
    for (const std::string& name : values) row.push_back(value_cell(trial, name));
    row.push_back(text_cell(trial.error()));
    table.rows.push_back(std::move(row));
  }
  return table;
}

ExitCode exit_code_of(const v1::Study& study) {
  if (study.state() == v1::Study::ERROR) return ExitCode::job_failed;
  if (study.state() == v1::Study::CANCELLED) return ExitCode::cancelled;
  return ExitCode::ok;
}

// A sweep that is complete may still hold failed trials: the first one decides, as for jobs.
ExitCode exit_code_of(const std::vector<v1::Trial>& trials) {
  for (const v1::Trial& trial : trials)
    if (trial.state() != v1::COMPLETE) return granary::exit_code_of(trial.state(), false);
  return ExitCode::ok;
}

Status write_study_name(Context& context, const v1::Study& study) {
  if (context.format() == render::Format::table) return context.write(study.name() + "\n");
  render::Table table{{"study", "trials"}, {{study.name(), study.planned()}}};
  return context.write_rows(table, render::JsonShape::lines);
}

}  // namespace

bool is_study_name(const std::string& text) {
  return text.rfind(kPrefix, 0) == 0;
}

Result<std::string> study_name(const std::string& text) {
  const std::string id = is_study_name(text) ? text.substr(kPrefix.size()) : text;
  if (id.empty() || id.find_first_not_of("0123456789") != std::string::npos)
    return Error{ErrorCode::invalid_argument, "'" + text + "' is not a study name (studies/ID)",
                 "name"};
  return std::string(kPrefix) + id;
}

render::Table study_table(const std::vector<v1::Study>& studies, render::Format format) {
  const bool brief = format == render::Format::table;
  render::Table table;
  if (brief)
    table.columns = {"study", "title", "kind", "state", "progress", "result"};
  else
    table.columns = {
        "study",         "title",         "kind",       "state",          "owner",
        "submitted",     "ended",         "planned",    "trials",         "ended_trials",
        "failed_trials", "reused_trials", "best_trial", "best_objective", "best_objective_error",
        "best_inputs",   "verdict",       "message"};
  for (const v1::Study& study : studies)
    table.rows.push_back(brief ? brief_row(study) : full_row(study));
  return table;
}

render::Table trial_table(const std::vector<v1::Trial>& trials, render::Format format) {
  if (format == render::Format::table) return brief_trials(trials);
  render::Table table{{"study", "number", "job", "state", "role", "candidate", "inputs",
                       "objective", "objective_error", "feasible", "best_objective", "pareto",
                       "values", "cpu_s", "reused", "error"},
                      {}};
  for (const v1::Trial& trial : trials) table.rows.push_back(full_row(trial));
  return table;
}

Outcome follow_study(Context& context, const std::string& name, bool json_lines) {
  auto session = context.session();
  if (!session) return session.error();
  session::Interrupt interrupt;
  std::string shown;
  const auto show = [&](const v1::Study& study) {
    if (json_lines) {
      const auto table = study_table({study}, render::Format::json);
      (void)context.write(
          render::render_rows(table, render::Format::json, render::JsonShape::lines));
      return;
    }
    std::string line = study.name() + " " + state_text(study.state()) + ": " + progress_text(study);
    if (!study.summary().verdict().empty()) line += "; " + study.summary().verdict();
    if (line != shown) context.say(line);
    shown = line;
  };
  auto ended = (*session)->watch_study(name, show, interrupt);
  if (!ended) return ended.error();
  if (*ended) return exit_code_of(**ended);
  context.say("detached; " + name + " goes on. Watch it again: granary watch " + name);
  return ExitCode::interrupted;
}

Outcome submit_study(Context& context, v1::SubmitStudyRequest request, bool wait) {
  auto session = context.session();
  if (!session) return session.error();
  auto study = (*session)->submit_study(std::move(request));
  if (!study) return study.error();
  if (!wait) {
    if (auto written = write_study_name(context, *study); !written) return written.error();
    return ExitCode::ok;
  }
  const Outcome outcome = follow_study(context, study->name(), false);
  if (!outcome || *outcome == ExitCode::interrupted) return outcome;
  auto trials = (*session)->trials(study->name());
  if (!trials) return trials.error();
  const auto table = trial_table(*trials, context.format());
  if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
    return written.error();
  return *outcome != ExitCode::ok ? *outcome : exit_code_of(*trials);
}

}  // namespace granary::commands
