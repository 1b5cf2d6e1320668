// granary fetch: the HDF5 result of a job.
#include "client/session/fetch.h"

#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"
#include "client/render/byte_progress.h"
#include "client/render/progress_display.h"

namespace granary::commands {
namespace {

std::string default_file(const std::string& job) {
  std::string name = job;
  for (char& letter : name)
    if (letter == '/') letter = '-';
  return name + ".h5";
}

Outcome fetch(Context& context, const std::string& text, bool force) {
  auto job = job_name(text);
  if (!job) return job.error();
  auto session = context.session();
  if (!session) return session.error();
  const std::string& wanted = context.options().output;
  const session::FetchRequest request{*job, wanted.empty() ? default_file(*job) : wanted, force};
  render::ByteProgress bytes(!context.options().quiet && render::terminal_of_stderr().is_terminal);
  session::Interrupt interrupt;
  auto fetched = session::fetch_result(
      **session, request,
      [&](std::uint64_t have_bytes, std::uint64_t size_bytes) {
        bytes.show(have_bytes, size_bytes);
      },
      interrupt);
  bytes.close();
  if (!fetched && interrupt.requested()) {
    context.say("interrupted; the same command continues");
    return ExitCode::interrupted;
  }
  if (!fetched) return fetched.error();
  if (fetched->was_there) context.say(request.file.string() + " is already there");
  const render::Table table{{"job", "file", "size_bytes", "sha256"},
                            {{*job, request.file.string(), fetched->size_bytes, fetched->sha256}}};
  if (auto written = context.write_listing(table, 1); !written) return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_fetch(CommandLine& line) {
  auto name = std::make_shared<std::string>();
  auto force = std::make_shared<bool>(false);
  CLI::App& verb = line.verb("fetch", "Download a job's HDF5 result; continues where it stopped",
                             "granary fetch jobs/12 -o bucket.h5");
  verb.add_option("JOB", *name, "job name")->required()->type_name("");
  verb.add_flag("--force", *force, "replace a file that has other content");
  line.on(verb, [name, force](Context& context) { return fetch(context, *name, *force); });
}

}  // namespace granary::commands
