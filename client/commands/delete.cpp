// granary delete: forget jobs and their results.
#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"

namespace granary::commands {
namespace {

Outcome delete_jobs(Context& context, const JobNames& names) {
  return for_each_job(context, names, [&](session::Session& session, const std::string& name) {
    if (auto removed = session.remove(name); !removed) return Outcome(removed.error());
    context.say("deleted " + name);
    return Outcome(ExitCode::ok);
  });
}

}  // namespace

void add_delete(CommandLine& line) {
  auto names = std::make_shared<JobNames>();
  CLI::App& verb =
      line.verb("delete", "Forget ended jobs and their results", "granary delete jobs/12 jobs/13");
  add_job_names(verb, *names);
  line.on(verb, [names](Context& context) { return delete_jobs(context, *names); });
}

}  // namespace granary::commands
