#include "client/commands/follow.h"

#include <google/protobuf/util/time_util.h>

#include <chrono>
#include <iostream>
#include <map>

#include "client/render/progress_display.h"
#include "proto/contract/job_state.h"

namespace granary::commands {
namespace {

using render::Json;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Json progress_json(const v1::Progress& progress) {
  Json values = Json::object();
  const std::map<std::string, double> sorted(progress.current_values().begin(),
                                             progress.current_values().end());
  for (const auto& [name, value] : sorted) values[name] = render::number_or_null(value);
  return {{"fraction", render::number_or_null(progress.fraction())},
          {"phase", progress.phase()},
          {"time_s", render::number_or_null(progress.time_s())},
          {"end_time_s", render::number_or_null(progress.end_time_s())},
          {"particles", progress.particles()},
          {"contacts", progress.contacts()},
          {"steps", progress.steps()},
          {"ns_per_particle_step", render::number_or_null(progress.ns_per_particle_step())},
          {"eta_s", render::number_or_null(progress.eta_s())},
          {"ledger_remainder_ratio", render::number_or_null(progress.ledger_remainder_ratio())},
          {"current_values", values}};
}

std::string event_line(const std::string& job, const v1::JobEvent& event) {
  Json line = {{"job", job}, {"sequence", event.sequence()}};
  if (event.has_time()) line["time"] = google::protobuf::util::TimeUtil::ToString(event.time());
  if (event.what_case() == v1::JobEvent::kState) line["state"] = to_string(event.state());
  if (event.what_case() == v1::JobEvent::kProgress)
    line["progress"] = progress_json(event.progress());
  if (!event.message().empty()) line["message"] = event.message();
  return render::compact(line) + "\n";
}

session::EventSink sink_for(Context& context, const std::string& name, EventOutput output,
                            render::ProgressDisplay& display) {
  if (output == EventOutput::json_lines)
    return [&context, name](const v1::JobEvent& event) {
      (void)context.write(event_line(name, event));
    };
  if (context.options().quiet) return [](const v1::JobEvent&) {};
  return [&display](const v1::JobEvent& event) { display.show(event, now_s()); };
}

void tell_end(Context& context, const v1::Job& job) {
  if (job.state() == v1::COMPLETE && !job.timed_out()) return;
  std::string what =
      job.name() + ": " + (job.timed_out() ? "timed out" : std::string(to_string(job.state())));
  if (!job.error().empty()) what += ": " + job.error();
  context.complain({ErrorCode::unknown, what, ""});
}

}  // namespace

Outcome follow_jobs(Context& context, const std::vector<std::string>& names, EventOutput output,
                    std::vector<v1::Job>& ended) {
  auto session = context.session();
  if (!session) return session.error();
  session::Interrupt interrupt;
  ExitCode first = ExitCode::ok;
  for (const std::string& name : names) {
    render::ProgressDisplay display(std::cerr, render::terminal_of_stderr(), name);
    auto job = (*session)->watch(name, sink_for(context, name, output, display), interrupt);
    display.close();
    if (!job) return job.error();
    if (!*job) {
      context.say("detached; " + name + " goes on. Watch it again: granary watch " + name);
      return ExitCode::interrupted;
    }
    tell_end(context, **job);
    ended.push_back(**job);
    if (first == ExitCode::ok) first = exit_code_of((*job)->state(), (*job)->timed_out());
  }
  return first;
}

}  // namespace granary::commands
