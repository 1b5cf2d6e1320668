#include "worker/run/pacing.h"

#include <algorithm>

namespace granary::run {

void ChunkPacer::note(std::uint64_t steps_done, double seconds) {
  // A chunk cut short by a frame or by the end of the run says little about a step's cost.
  if (steps_done == 0 || (steps_done < steps_ && seconds < kChunkSeconds)) return;
  const double steps_per_chunk =
      seconds > 0 ? static_cast<double>(steps_done) * kChunkSeconds / seconds : 2.0 * steps_;
  const double bounded = std::min(steps_per_chunk, 2.0 * static_cast<double>(steps_));
  steps_ = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(bounded));
}

void CheckpointPacer::note(double now_s, double cost_s) {
  next_s_ = interval_s_ > 0 ? now_s + std::max(interval_s_, cost_s / kCheckpointCostShare) : now_s;
}

}  // namespace granary::run
