#include "client/commands/jobs.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <cctype>
#include <iostream>
#include <map>

#include "proto/contract/job_state.h"

namespace granary::commands {
namespace {

using google::protobuf::Timestamp;
using google::protobuf::util::TimeUtil;
using render::Json;

constexpr std::string_view kPrefix = "jobs/";

Json time_cell(bool is_set, const Timestamp& time) {
  return is_set ? Json(TimeUtil::ToString(time)) : Json(nullptr);
}

Json text_cell(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

Json tags_cell(const v1::Job& job) {
  const std::map<std::string, std::string> sorted(job.tags().begin(), job.tags().end());
  return sorted.empty() ? Json::object() : Json(sorted);
}

// Seconds from start to end, or to now while it runs.
Json elapsed_cell(const v1::Job& job) {
  if (!job.has_started()) return nullptr;
  const Timestamp end = job.has_ended() ? job.ended() : TimeUtil::GetCurrentTime();
  const auto elapsed = TimeUtil::DurationToMilliseconds(end - job.started());
  return static_cast<double>(elapsed) / 1000.0;
}

double fraction_of(const v1::Job& job) {
  if (job.state() == v1::COMPLETE) return 1;
  return std::clamp(job.progress().fraction(), 0.0, 1.0);
}

std::vector<Json> full_row(const v1::Job& job) {
  return {job.name(),
          job.kind(),
          to_string(job.state()),
          fraction_of(job),
          job.priority(),
          tags_cell(job),
          time_cell(job.has_submitted(), job.submitted()),
          time_cell(job.has_started(), job.started()),
          time_cell(job.has_ended(), job.ended()),
          job.attempts(),
          text_cell(job.worker()),
          text_cell(job.owner()),
          text_cell(job.error()),
          job.time_limit_s() > 0 ? Json(job.time_limit_s()) : Json(nullptr),
          job.timed_out(),
          job.reused(),
          text_cell(job.study()),
          text_cell(job.key()),
          text_cell(job.result().sha256()),
          job.has_result() ? Json(job.result().size_bytes()) : Json(nullptr)};
}

std::vector<Json> brief_row(const v1::Job& job) {
  std::string state(to_string(job.state()));
  if (job.timed_out()) state += " (timed out)";
  if (job.reused()) state += " (reused)";
  const int percent = static_cast<int>(fraction_of(job) * 100 + 1e-9);
  return {job.name(),
          job.kind(),
          state,
          std::to_string(percent) + " %",
          time_cell(job.has_submitted(), job.submitted()),
          elapsed_cell(job),
          text_cell(job.worker()),
          tags_cell(job),
          text_cell(job.error())};
}

bool is_name_letter(unsigned char letter) {
  return std::isalnum(letter) || letter == '-' || letter == '_' || letter == '.';
}

Result<JobNames> expanded(const JobNames& given) {
  JobNames names;
  const auto add = [&](const std::string& text) -> Status {
    auto name = job_name(text);
    if (!name) return name.error();
    names.push_back(*name);
    return Done{};
  };
  for (const std::string& text : given) {
    if (text != "-") {
      if (auto added = add(text); !added) return added.error();
      continue;
    }
    for (std::string line; std::getline(std::cin, line);)
      if (!line.empty())
        if (auto added = add(line); !added) return added.error();
  }
  return names;
}

}  // namespace

void add_job_names(CLI::App& verb, JobNames& names) {
  verb.add_option("JOB", names, "job names; - reads them from stdin, one a line")
      ->required()
      ->type_name("");
}

Result<std::string> job_name(const std::string& text) {
  const bool prefixed = text.rfind(kPrefix, 0) == 0;
  const std::string id = prefixed ? text.substr(kPrefix.size()) : text;
  if (id.empty() || id.size() > 128 || !std::all_of(id.begin(), id.end(), is_name_letter))
    return Error{ErrorCode::invalid_argument, "'" + text + "' is not a job name (jobs/ID)", "name"};
  return std::string(kPrefix) + id;
}

Outcome for_each_job(Context& context, const JobNames& given, const JobAction& act) {
  auto names = expanded(given);
  if (!names) return names.error();
  auto session = context.session();
  if (!session) return session.error();
  ExitCode first = ExitCode::ok;
  for (const std::string& name : *names) {
    Outcome outcome = act(**session, name);
    if (!outcome) context.complain(outcome.error());
    const ExitCode code = outcome ? *outcome : exit_code_of(outcome.error().code);
    if (first == ExitCode::ok) first = code;
    if (code == ExitCode::unreachable) break;  // the next one would wait for the same server
  }
  return first;
}

render::Table job_table(const std::vector<v1::Job>& jobs, render::Format format) {
  render::Table table;
  const bool brief = format == render::Format::table;
  if (brief)
    table.columns = {"job",       "kind",   "state", "done", "submitted",
                     "elapsed_s", "worker", "tags",  "error"};
  else
    table.columns = {"job",    "kind",      "state",   "fraction",      "priority",
                     "tags",   "submitted", "started", "ended",         "attempts",
                     "worker", "owner",     "error",   "time_limit_s",  "timed_out",
                     "reused", "study",     "key",     "result_sha256", "result_size_bytes"};
  for (const v1::Job& job : jobs) table.rows.push_back(brief ? brief_row(job) : full_row(job));
  return table;
}

Outcome change_jobs(Context& context, const JobNames& names, JobChange change) {
  std::vector<v1::Job> changed;
  const Outcome outcome =
      for_each_job(context, names, [&](session::Session& session, const std::string& name) {
        auto job = (session.*change)(name);
        if (!job) return Outcome(job.error());
        changed.push_back(*job);
        return Outcome(ExitCode::ok);
      });
  if (!changed.empty()) {
    const auto table = job_table(changed, context.format());
    if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
      return written.error();
  }
  return outcome;
}

}  // namespace granary::commands
