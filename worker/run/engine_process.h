// The engine as a process of its own, so that a crash, a leak or a kill costs one task and nothing
// else. It talks to its parent through a directory and a pipe:
//
//   DIR/task.pb        in   granary.v1.TaskAssignment
//   DIR/filling.in     in   a stored filling (optional; worker/storage/checkpoint.h)
//   DIR/checkpoint*    in/out, DIR/segment-*: resumed from when they are of this very run
//   stdout             out  granary.v1.Progress, each behind its length (4 bytes, little-endian).
//   An
//                           event that finds the pipe full is dropped: progress is never waited for
//   stderr             out  log, one line an entry
//   DIR/result.h5      out  the result file
//   DIR/filling.out    out  the settled filling, for others
//   DIR/finished.pb    out  granary.v1.TaskFinished without token; written last, atomically
//
// SIGTERM: checkpoint, then RELEASED. SIGINT: CANCELLED. Parent dead (or nobody reads the pipe):
// end.
#pragma once

#include <sys/types.h>

#include "worker/run/task_setup.h"
#include "worker/storage/file_system.h"

namespace granary::run {

// Returns the exit code: 0 once DIR/finished.pb is written, whatever the outcome in it.
// `parent` is the process that must stay alive, 0 when nobody minds.
int run_engine_process(const storage::Path& directory, pid_t parent, const EngineBuild& build);

}  // namespace granary::run
