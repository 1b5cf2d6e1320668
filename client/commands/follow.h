// Watching jobs to their end: what `run`, `watch` and `submit --wait` share.
#pragma once

#include <string>
#include <vector>

#include "client/commands/command_line.h"
#include "client/session/interrupt.h"

namespace granary::commands {

// How events are shown: as json lines on stdout, else as a bar or plain lines on stderr.
enum class EventOutput { display, json_lines };

// Follows each job in turn until it has ended. Says why a job failed. The exit code is the first
// that is not ok, `interrupted` after Ctrl-C: the jobs go on, and how to resume is printed.
Outcome follow_jobs(Context& context, const std::vector<std::string>& names, EventOutput output,
                    std::vector<v1::Job>& ended);

}  // namespace granary::commands
