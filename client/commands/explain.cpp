// granary explain: every setting of a job, who chose it and on what evidence.
#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"

namespace granary::commands {
namespace {

Outcome explain(Context& context, const std::string& text) {
  auto name = job_name(text);
  if (!name) return name.error();
  auto session = context.session();
  if (!session) return session.error();
  auto values = (*session)->values(*name);
  if (!values) return values.error();
  if (values->result().decisions().empty())
    return Error{ErrorCode::failed_precondition, *name + " has no stored decisions yet", ""};
  render::Table table{{"path", "value", "chosen_by", "evidence"}, {}};
  for (const auto& decision : values->result().decisions())
    table.rows.push_back(
        {decision.path(), decision.value(), decision.chosen_by(), decision.evidence()});
  for (const std::string& warning : values->result().warnings()) context.say("warning: " + warning);
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
    return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_explain(CommandLine& line) {
  auto name = std::make_shared<std::string>();
  CLI::App& verb = line.verb("explain", "Every setting of a job, who chose it and why",
                             "granary explain jobs/12");
  verb.add_option("JOB", *name, "job name")->required()->type_name("");
  line.on(verb, [name](Context& context) { return explain(context, *name); });
}

}  // namespace granary::commands
