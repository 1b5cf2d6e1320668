// granary watch: progress of a job until it ends. Ctrl-C detaches.
#include "client/commands/catalogue.h"
#include "client/commands/follow.h"
#include "client/commands/jobs.h"

namespace granary::commands {
namespace {

Outcome watch(Context& context, const std::string& text) {
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
      line.verb("watch", "Follow a job; Ctrl-C detaches, never cancels", "granary watch jobs/12");
  verb.add_option("JOB", *name, "job name")->required()->type_name("");
  line.on(verb, [name](Context& context) { return watch(context, *name); });
}

}  // namespace granary::commands
