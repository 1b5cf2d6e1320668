// granary cancel: stop waiting or running jobs.
#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"

namespace granary::commands {

void add_cancel(CommandLine& line) {
  auto names = std::make_shared<JobNames>();
  CLI::App& verb = line.verb("cancel", "Stop waiting or running jobs", "granary cancel jobs/12");
  add_job_names(verb, *names);
  line.on(verb, [names](Context& context) {
    return change_jobs(context, *names, &session::Session::cancel);
  });
}

}  // namespace granary::commands
