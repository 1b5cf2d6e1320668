// granary sweep: one scene, some of its fields varied. Prints the study's name.
#include <charconv>

#include "client/commands/catalogue.h"
#include "client/commands/duration.h"
#include "client/commands/studies.h"
#include "client/commands/submission.h"
#include "proto/contract/field_path.h"

namespace granary::commands {
namespace {

struct SweepOptions {
  SubmissionOptions submission;
  std::vector<std::string> vary;
  std::uint32_t samples = 0;
  std::uint64_t seed = 1;
  std::string name;
  bool list = false;
  bool wait = false;
};

Error bad_vary(const std::string& text, const std::string& what) {
  return {ErrorCode::invalid_argument, "--vary '" + text + "' " + what, ""};
}

bool is_number(std::string_view text, double* out) {
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return error == std::errc() && rest == text.data() + text.size();
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (char letter : text)
    if (letter == separator)
      parts.emplace_back();
    else
      parts.back() += letter;
  return parts;
}

// Fields that take any number: only there does a Latin hypercube read "8,11" as a range.
bool is_real_field(const std::string& path) {
  v1::Scene scene;
  return set_field(scene, path, "0.5").ok() && !set_field(scene, path, "x").ok();
}

// "8:12" is a range, "8:12:5" five values from 8 to 12.
Result<bool> read_range(const std::string& text, const std::string& values,
                        v1::Sweep::Variable& variable) {
  const std::vector<std::string> parts = split(values, ':');
  double low = 0, high = 0, count = 0;
  if (parts.size() < 2 || !is_number(parts[0], &low) || !is_number(parts[1], &high)) return false;
  if (parts.size() == 2) {
    variable.set_minimum(low);
    variable.set_maximum(high);
    return true;
  }
  if (parts.size() > 3 || !is_number(parts[2], &count) || count < 2 || count > 100'000)
    return bad_vary(text, "is not of the form path=from:to:count with count >= 2");
  for (int i = 0; i < static_cast<int>(count); ++i) {
    char number[32];
    std::snprintf(number, sizeof number, "%.12g", low + i * (high - low) / (count - 1));
    variable.add_values(number);
  }
  return true;
}

void make_range_of(v1::Sweep::Variable& variable) {
  double low = 0, high = 0, value = 0;
  for (int i = 0; i < variable.values_size(); ++i) {
    if (!is_number(variable.values(i), &value)) return;
    low = i == 0 ? value : std::min(low, value);
    high = i == 0 ? value : std::max(high, value);
  }
  if (!(low < high)) return;
  variable.clear_values();
  variable.set_minimum(low);
  variable.set_maximum(high);
}

Status add_variable(const std::string& text, bool sampled, v1::Sweep& sweep) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    return bad_vary(text, "is not of the form path=a,b,c or path=from:to:count");
  v1::Sweep::Variable& variable = *sweep.add_vary();
  variable.set_path(text.substr(0, equals));
  const std::string values = text.substr(equals + 1);
  auto range = read_range(text, values, variable);
  if (!range) return range.error();
  if (*range) return Done{};
  for (const std::string& value : split(values, ',')) variable.add_values(value);
  if (sampled && is_real_field(variable.path())) make_range_of(variable);
  return Done{};
}

Result<v1::SubmitStudyRequest> request_of(Context& context, const SweepOptions& options) {
  auto settings = context.settings();
  if (!settings) return settings.error();
  const int threads = std::atoi((*settings)[session::SettingKey::threads].value.c_str());
  auto jobs = make_request(options.submission, static_cast<std::uint32_t>(threads));
  if (!jobs) return jobs.error();
  const auto& item = jobs->items(0);
  v1::SubmitStudyRequest request;
  request.set_request_id(options.submission.request_id);
  v1::StudySpec& spec = *request.mutable_spec();
  if (!options.name.empty()) spec.set_name(options.name);
  *spec.mutable_scene() = item.scene();
  *spec.mutable_tags() = item.tags();
  spec.set_priority(item.priority());
  spec.set_time_limit_s(item.time_limit_s());
  spec.set_fresh(item.fresh());
  spec.set_seed(options.seed);
  v1::Sweep& sweep = *spec.mutable_sweep();
  sweep.set_design(options.samples > 0 ? v1::Sweep::LATIN_HYPERCUBE
                   : options.list      ? v1::Sweep::LIST
                                       : v1::Sweep::GRID);
  if (options.samples > 0) sweep.set_samples(options.samples);
  for (const std::string& text : options.vary)
    if (auto added = add_variable(text, options.samples > 0, sweep); !added) return added.error();
  return request;
}

Outcome sweep(Context& context, const SweepOptions& options) {
  auto request = request_of(context, options);
  if (!request) return request.error();
  return submit_study(context, std::move(*request), options.wait);
}

}  // namespace

void add_sweep(CommandLine& line) {
  auto options = std::make_shared<SweepOptions>();
  CLI::App& verb = line.verb(
      "sweep", "Queue a sweep: one scene, some fields varied; prints the study's name",
      "granary sweep a.txtpb --vary discharge.rotation_rad_per_s=8,9,10 --vary seed=1,2 --wait");
  add_scene_options(verb, options->submission, false);
  add_submission_options(verb, options->submission);
  verb.add_option("--vary", options->vary,
                  "path=a,b,c, path=from:to:count, or with --samples path=from:to (repeatable)")
      ->required()
      ->allow_extra_args(false)
      ->type_name("PATH=VALUES");
  verb.add_option("--samples", options->samples,
                  "a Latin hypercube of this many points instead of every combination")
      ->check(CLI::Range(1, 100'000));
  verb.add_option("--seed", options->seed, "of the Latin hypercube (default 1)");
  verb.add_flag("--list", options->list, "the first values together, then the second ones, ...")
      ->excludes("--samples");
  verb.add_option("--name", options->name, "title of the study");
  verb.add_flag("--wait", options->wait, "until it has ended; prints its trials");
  line.on(verb, [options](Context& context) { return sweep(context, *options); });
}

}  // namespace granary::commands
