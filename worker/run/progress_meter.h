// What a watcher is told: how far, how fast, how long still. Throttled, so that it costs nothing.
#pragma once

#include <cstdint>

#include "granary/v1/result.pb.h"
#include "worker/core/simulation.h"
#include "worker/run/pacing.h"

namespace granary::run {

class ProgressMeter {
 public:
  ProgressMeter(std::uint32_t replicates, double now_s)
      : replicates_(replicates), start_s_(now_s) {}

  bool due(double now_s) const { return pacer_.due(now_s); }
  // `engine_seconds` and `particle_steps` are of this attempt: their ratio is the speed shown.
  v1::Progress take(const core::SimulationProgress& simulation, std::uint32_t replicate,
                    double now_s, double engine_seconds, std::uint64_t particle_steps);

 private:
  double remaining_s(double fraction, double now_s);

  std::uint32_t replicates_;
  double start_s_;
  double start_fraction_ = -1;  // where this attempt began: a resumed run starts in the middle
  ProgressPacer pacer_;
};

}  // namespace granary::run
