// granary status: jobs as they are now.
#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"

namespace granary::commands {

void add_status(CommandLine& line) {
  auto names = std::make_shared<JobNames>();
  CLI::App& verb =
      line.verb("status", "Show jobs as they are now", "granary status jobs/12 --format json");
  add_job_names(verb, *names);
  line.on(verb, [names](Context& context) {
    return change_jobs(context, *names, &session::Session::get);
  });
}

}  // namespace granary::commands
