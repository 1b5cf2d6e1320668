// granary submit: queue scenes. Job names alone on stdout, one a line.
#include "client/commands/catalogue.h"
#include "client/commands/follow.h"
#include "client/commands/submission.h"
#include "client/commands/values_output.h"

namespace granary::commands {
namespace {

Status write_names(Context& context, const std::vector<std::string>& names) {
  if (context.format() != render::Format::table) {
    render::Table table{{"job"}, {}};
    for (const std::string& name : names) table.rows.push_back({name});
    return context.write_rows(table, render::JsonShape::lines);
  }
  std::string text;
  for (const std::string& name : names) text += name + "\n";
  return context.write(text);
}

Outcome submit(Context& context, const SubmissionOptions& options, bool wait) {
  auto names = submit_scenes(context, options);
  if (!names) return names.error();
  // With --wait, json and csv carry the values; the plain form stays names alone.
  const bool values_follow = wait && context.format() != render::Format::table;
  if (!values_follow)
    if (auto written = write_names(context, *names); !written) return written.error();
  if (!wait) return ExitCode::ok;
  std::vector<v1::Job> ended;
  const Outcome outcome = follow_jobs(context, *names, EventOutput::display, ended);
  if (!outcome || *outcome == ExitCode::interrupted || !values_follow) return outcome;
  if (auto written = write_values_of(context, *names); !written) return written.error();
  return outcome;
}

}  // namespace

void add_submit(CommandLine& line) {
  auto options = std::make_shared<SubmissionOptions>();
  auto wait = std::make_shared<bool>(false);
  CLI::App& verb = line.verb("submit", "Queue scenes; prints one job name a line",
                             "granary submit a.txtpb b.txtpb --tag study=walls --time-limit 10m");
  add_scene_options(verb, *options, true);
  add_submission_options(verb, *options);
  verb.add_flag("--wait", *wait, "until all have ended; json and csv then give their values");
  line.on(verb, [options, wait](Context& context) { return submit(context, *options, *wait); });
}

}  // namespace granary::commands
