// What the run layer itself must remember across a kill: finished replicates, the frame schedule
// and the price so far. Goes into checkpoints as bytes beside the engine's snapshot; a checkpoint
// of another engine version is refused before they are read, so they carry no version of their own.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/run/frame_schedule.h"
#include "worker/run/recovery.h"
#include "worker/run/replicates.h"
#include "worker/storage/column_codec.h"

namespace granary::run {

// Sums over all replicates and attempts, except the engine's own counters of the current replicate.
struct RunCosts {
  double wall_s = 0;
  double cpu_s = 0;          // whole process: engine, output, checkpoints
  double engine_wall_s = 0;  // inside advance() only
  double engine_cpu_s = 0;
  double reused_s = 0;  // CPU seconds of a stored filling
  std::uint64_t peak_rss_bytes = 0;
  std::uint64_t steps = 0;
  std::uint64_t particle_steps = 0;
  double contacts_per_particle_sum = 0;  // seen at the end of each chunk, times its particle steps
};

struct RunRecord {
  std::vector<FinishedReplicate> finished;
  core::Observation first;  // series, fields, warnings, effect counts of replicate 0
  FrameSchedule::State frames;
  RunCosts costs;
  Mark mark;                         // of the replicate that is running
  std::vector<Recovery> recoveries;  // of the same
  std::vector<RecoveryNote> notes;   // of all
};

storage::Bytes encode(const RunRecord& record);
// Throws storage::StorageError(damaged) when the bytes are none of ours.
RunRecord decode_record(const storage::Bytes& bytes);

}  // namespace granary::run
