// A task that asks for an accuracy: pilots, the cheapest setting that meets the target, the main
// run, and its values with all parts of their error.
#pragma once

#include "worker/run/task.h"

namespace granary::run {

// run_task() for every scene; one with `accuracy.target` is piloted first. Pilots store nothing: a
// task that is stopped in them starts them again.
TaskOutcome run_request(const TaskSpec& spec, const SimulationFactory& factory,
                        const TaskCallbacks& callbacks, const StopSignal& stop,
                        storage::FileSystem& files = storage::real_file_system());

}  // namespace granary::run
