// From a scene as submitted to a task: the same resolution for the service and for `--scene FILE`.
#pragma once

#include <string>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"
#include "worker/run/task.h"

namespace granary::run {

// Which engine build this is, as far as it decides bits.
struct EngineBuild {
  SimulationFactory factory;
  std::string vector_path;
};

// INVALID_ARGUMENT with the field path when the scene is not valid. Paths and limits are left to
// the caller. GRANARY_CHECKPOINT_INTERVAL_S overrides the seconds between checkpoints.
Result<TaskSpec> make_task(const v1::Scene& submitted, const EngineBuild& build);

}  // namespace granary::run
