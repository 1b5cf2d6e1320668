// Takes the frames of a run when they are due and puts them into its storage.
#pragma once

#include "worker/run/frame_schedule.h"
#include "worker/run/run_storage.h"
#include "worker/run/watched_engine.h"

namespace granary::run {

class FrameKeeper {
 public:
  FrameKeeper(const v1::Output& output, RunStorage& storage)
      : output_(output), schedule_(output), storage_(storage) {}

  // Both give false when the frame holds something that is no number; the engine knows what.
  bool keep_due(WatchedEngine& engine);
  bool keep_last(WatchedEngine& engine);  // of a finished scenario

  double limit_s() const { return schedule_.limit_s(); }
  const FrameSchedule::State& state() const { return schedule_.state(); }
  void restore(const FrameSchedule::State& state) { schedule_.restore(state); }
  double output_cpu_s() const { return output_cpu_s_; }

 private:
  bool keep(WatchedEngine& engine);
  std::vector<core::ColumnView> wanted(std::vector<core::ColumnView> columns) const;

  v1::Output output_;
  FrameSchedule schedule_;
  RunStorage& storage_;
  double output_cpu_s_ = 0;
};

}  // namespace granary::run
