// granary retry: queue failed or cancelled jobs again.
#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"

namespace granary::commands {

void add_retry(CommandLine& line) {
  auto names = std::make_shared<JobNames>();
  CLI::App& verb =
      line.verb("retry", "Queue failed or cancelled jobs again", "granary retry jobs/12");
  add_job_names(verb, *names);
  line.on(verb, [names](Context& context) {
    return change_jobs(context, *names, &session::Session::retry);
  });
}

}  // namespace granary::commands
