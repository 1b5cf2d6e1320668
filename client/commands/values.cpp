// granary values: what jobs gave, with error bars.
#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"
#include "client/commands/values_output.h"
#include "proto/contract/job_state.h"

namespace granary::commands {
namespace {

Outcome show_values(Context& context, const JobNames& names) {
  std::vector<v1::GetValuesResponse> responses;
  const Outcome outcome = for_each_job(
      context, names, [&](session::Session& session, const std::string& name) -> Outcome {
        auto values = session.values(name);
        if (!values) return values.error();
        if (!is_final(values->state()))
          return Error{ErrorCode::failed_precondition,
                       name + " is " + std::string(to_string(values->state())) +
                           ": no values yet (granary watch " + name + ")",
                       ""};
        responses.push_back(*values);
        const ExitCode code = exit_code_of(values->state(), values->timed_out());
        if (code != ExitCode::ok)
          context.complain({ErrorCode::unknown,
                            name + ": " + std::string(to_string(values->state())) +
                                (values->error().empty() ? "" : ": " + values->error()),
                            ""});
        return code;
      });
  if (!outcome) return outcome;
  if (auto written = write_values(context, responses); !written) return written.error();
  return outcome;
}

}  // namespace

void add_values(CommandLine& line) {
  auto names = std::make_shared<JobNames>();
  CLI::App& verb = line.verb("values", "Print the values of ended jobs, each with its error",
                             "granary values jobs/12 --format json");
  add_job_names(verb, *names);
  line.on(verb, [names](Context& context) { return show_values(context, *names); });
}

}  // namespace granary::commands
