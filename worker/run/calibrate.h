// What a finished run teaches about the speed of this host (proto/contract/calibration.h).
#pragma once

#include "worker/run/task.h"

namespace granary::run {

// Nothing is learnt from short runs, from runs that used a stored filling, changed their settings
// or were piloted: they did not do the work that the price list counts.
void note_speed(const TaskSpec& spec, const TaskOutcome& outcome);

}  // namespace granary::run
