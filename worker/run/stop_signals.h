// The one stop flag of a worker process that runs an engine, and the signals that set it.
#pragma once

#include "worker/run/task.h"

namespace granary::run {

StopSignal& stop_signal();

// Installs handlers: SIGINT asks for `on_interrupt`, SIGTERM for `on_terminate`; a second one of
// either ends the process at once. SIGPIPE is ignored: a closed pipe shows as EPIPE.
void listen_to_stop_signals(StopRequest on_interrupt, StopRequest on_terminate);

}  // namespace granary::run
