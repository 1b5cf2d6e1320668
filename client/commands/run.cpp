// granary run: submit, watch, print values.
#include "client/commands/catalogue.h"
#include "client/commands/follow.h"
#include "client/commands/submission.h"
#include "client/commands/values_output.h"

namespace granary::commands {
namespace {

Outcome run_scene(Context& context, const SubmissionOptions& options) {
  auto names = submit_scenes(context, options);
  if (!names) return names.error();
  for (const std::string& name : *names) context.say("submitted " + name);
  std::vector<v1::Job> ended;
  const Outcome outcome = follow_jobs(context, *names, EventOutput::display, ended);
  if (!outcome || *outcome == ExitCode::interrupted) return outcome;
  if (auto written = write_values_of(context, *names); !written) return written.error();
  return outcome;
}

}  // namespace

void add_run(CommandLine& line) {
  auto options = std::make_shared<SubmissionOptions>();
  CLI::App& verb = line.verb("run", "Submit a scene, watch it, print its values",
                             "granary run scene.txtpb --set discharge.rotation_rad_per_s=10.5");
  add_scene_options(verb, *options, false);
  add_submission_options(verb, *options);
  line.on(verb, [options](Context& context) { return run_scene(context, *options); });
}

}  // namespace granary::commands
