// granary logs: what the worker said while it ran a job.
#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"

namespace granary::commands {
namespace {

Status write_logs(Context& context, const std::string& name,
                  const std::vector<std::string>& lines) {
  if (context.format() == render::Format::table) {
    std::string text;
    for (const std::string& log_line : lines) text += render::printable(log_line) + "\n";
    return context.write(text);
  }
  render::Table table{{"job", "line"}, {}};
  for (const std::string& log_line : lines) table.rows.push_back({name, log_line});
  return context.write_rows(table, render::JsonShape::array);
}

}  // namespace

void add_logs(CommandLine& line) {
  auto name = std::make_shared<std::string>();
  CLI::App& verb = line.verb("logs", "Show a job's log", "granary logs jobs/12");
  verb.add_option("JOB", *name, "job name")->required()->type_name("");
  line.on(verb, [name](Context& context) -> Outcome {
    auto job = job_name(*name);
    if (!job) return job.error();
    auto session = context.session();
    if (!session) return session.error();
    auto lines = (*session)->logs(*job);
    if (!lines) return lines.error();
    if (auto written = write_logs(context, *job, *lines); !written) return written.error();
    return ExitCode::ok;
  });
}

}  // namespace granary::commands
