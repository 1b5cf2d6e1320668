// granary watch: progress of a job or a study until it ends. Ctrl-C detaches.
#include "client/commands/catalogue.h"
#include "client/commands/follow.h"
#include "client/commands/jobs.h"
#include "client/commands/studies.h"

namespace granary::commands {
namespace {

Outcome watch_study(Context& context, const std::string& text) {
  auto name = study_name(text);
  if (!name) return name.error();
  const bool json = context.format() == render::Format::json;
  const Outcome outcome = follow_study(context, *name, json);
  if (json || !outcome || *outcome == ExitCode::interrupted) return outcome;
  auto session = context.session();
  if (!session) return session.error();
  auto study = (*session)->get_study(*name);
  if (!study) return study.error();
  const auto table = study_table({*study}, context.format());
  if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
    return written.error();
  return outcome;
}

Outcome watch(Context& context, const std::string& text) {
  if (is_study_name(text)) return watch_study(context, text);
  auto name = job_name(text);
  if (!name) return name.error();
  const bool json = context.format() == render::Format::json;
  std::vector<v1::Job> ended;
  const Outcome outcome =
      follow_jobs(context, {*name}, json ? EventOutput::json_lines : EventOutput::display, ended);
  if (json || ended.empty()) return outcome;
  const auto table = job_table(ended, context.format());
  if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
    return written.error();
  return outcome;
}

}  // namespace

void add_watch(CommandLine& line) {
  auto name = std::make_shared<std::string>();
  CLI::App& verb =
      line.verb("watch", "Follow a job or a study; Ctrl-C detaches, never cancels", "granary watch jobs/12");
  verb.add_option("JOB", *name, "job or study name")->required()->type_name("");
  line.on(verb, [name](Context& context) { return watch(context, *name); });
}

}  // namespace granary::commands
