#include "worker/run/history_console.h"

#include <google/protobuf/text_format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <set>

#include "granary/v1/study.pb.h"
#include "proto/contract/job_state.h"
#include "proto/contract/result.h"
#include "worker/storage/history_file.h"
#include "worker/storage/storage_error.h"

namespace granary::run {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

using Trials = google::protobuf::RepeatedPtrField<v1::Trial>;

storage::HistoryNumbers numbers(const Trials& trials, const char* name, const char* unit,
                                const std::function<double(const v1::Trial&)>& value) {
  storage::HistoryNumbers column{name, unit, {}};
  for (const v1::Trial& trial : trials) column.values.push_back(value(trial));
  return column;
}

storage::HistoryTexts texts(const Trials& trials, const char* name,
                            const std::function<std::string(const v1::Trial&)>& value) {
  storage::HistoryTexts column{name, {}};
  for (const v1::Trial& trial : trials) column.values.push_back(value(trial));
  return column;
}

void add_trials(const Trials& trials, storage::HistoryContent& content) {
  using T = const v1::Trial&;
  const auto known = [](bool is, double value) { return is ? value : kUnknown; };
  content.trial_numbers = {
      numbers(trials, "number", "1", [](T t) { return t.number(); }),
      numbers(trials, "candidate", "1", [](T t) { return t.candidate(); }),
      numbers(trials, "objective", "1",
              [&](T t) { return known(t.has_objective(), t.objective()); }),
      numbers(trials, "objective_error", "1",
              [&](T t) { return known(t.has_objective_error(), t.objective_error()); }),
      numbers(trials, "best_objective", "1",
              [&](T t) { return known(t.has_best_objective(), t.best_objective()); }),
      numbers(trials, "feasible", "1", [&](T t) { return known(t.has_feasible(), t.feasible()); }),
      numbers(trials, "pareto", "1", [](T t) { return t.pareto(); }),
      numbers(trials, "cpu_s", "s", [&](T t) { return known(t.cpu_s() > 0, t.cpu_s()); })};
  content.trial_texts = {
      texts(trials, "job", [](T t) { return t.job(); }),
      texts(trials, "state", [](T t) { return std::string(to_string(t.state())); }),
      texts(trials, "role", [](T t) { return t.role(); })};
}

bool is_number(const std::string& text, double* value) {
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc() && rest == text.data() + text.size();
}

void add_inputs(const Trials& trials, storage::HistoryContent& content) {
  std::set<std::string> paths;
  for (const v1::Trial& trial : trials)
    for (const auto& [path, value] : trial.inputs()) paths.insert(path);
  for (const std::string& path : paths) {
    storage::HistoryNumbers as_numbers{path, "", {}};
    storage::HistoryTexts as_texts{path, {}};
    bool all_numbers = true;
    for (const v1::Trial& trial : trials) {
      const auto found = trial.inputs().find(path);
      double value = kUnknown;
      if (found != trial.inputs().end() && !is_number(found->second, &value)) all_numbers = false;
      as_numbers.values.push_back(value);
      as_texts.values.push_back(found == trial.inputs().end() ? "" : found->second);
    }
    if (all_numbers)
      content.inputs.push_back(std::move(as_numbers));
    else
      content.input_texts.push_back(std::move(as_texts));
  }
}

void add_values(const Trials& trials, storage::HistoryContent& content) {
  std::map<std::string, std::string> units;
  for (const v1::Trial& trial : trials)
    for (const auto& [name, quantity] : trial.values()) units[name] = quantity.unit();
  for (const auto& [name, unit] : units) {
    storage::HistoryNumbers values{name, unit, {}}, errors{name, unit, {}};
    for (const v1::Trial& trial : trials) {
      const auto found = trial.values().find(name);
      const bool known = found != trial.values().end();
      values.values.push_back(known && found->second.has_value() ? found->second.value()
                                                                 : kUnknown);
      errors.values.push_back(known && found->second.has_error() ? found->second.error()
                                                                 : kUnknown);
    }
    content.values.push_back(std::move(values));
    content.errors.push_back(std::move(errors));
  }
}

storage::HistoryContent content_of(const v1::StudyHistory& history) {
  storage::HistoryContent content;
  content.study = history.study().name();
  content.kind = history.study().kind();
  content.state = v1::Study::State_Name(history.study().state());
  content.verdict = history.study().summary().verdict();
  google::protobuf::TextFormat::PrintToString(history.study().spec(), &content.spec_text);
  add_trials(history.trials(), content);
  add_inputs(history.trials(), content);
  add_values(history.trials(), content);
  return content;
}

}  // namespace

int history_console(const std::string& input_file, const std::string& output_file) {
  v1::StudyHistory history;
  std::ifstream in(input_file, std::ios::binary);
  if (!in || !history.ParseFromIstream(&in) || history.study().name().empty()) {
    std::cerr << "granary-worker: " << input_file << " holds no history of a study\n";
    return static_cast<int>(ExitCode::verification_failed);
  }
  try {
    storage::write_history(output_file, content_of(history));
  } catch (const storage::StorageError& error) {
    std::cerr << "granary-worker: " << error.what() << '\n';
    return static_cast<int>(ExitCode::usage);
  }
  return 0;
}

}  // namespace granary::run
