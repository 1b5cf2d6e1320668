// Runs one task from its scene to its result: advances the engine in chunks of about 50 ms, keeps
// frames and checkpoints, reports progress, obeys stop requests and limits, repeats it for error
// bars. Chunks, checkpoints, kills and threads never change a bit of the result.
#pragma once

#include "worker/run/task.h"

namespace granary::run {

// Resumes from a checkpoint in `spec.work_directory` when there is one of this very run. Every
// failure becomes an outcome:
//   COMPLETE   values and file are final          UNSTABLE   the engine gave up; the file holds the
//   CANCELLED, TIMED_OUT  no result                          frames up to then and no values
//   RELEASED   stopped with a checkpoint          ERROR      would fail again
//   CRASHED    the disk failed or is full: worth another try elsewhere
TaskOutcome run_task(const TaskSpec& spec, const SimulationFactory& factory,
                     const TaskCallbacks& callbacks, const StopSignal& stop,
                     storage::FileSystem& files = storage::real_file_system());

// Deletes segments and checkpoints of a run whose result has been taken over.
void remove_run_files(storage::FileSystem& files, const storage::Path& work_directory);

}  // namespace granary::run
