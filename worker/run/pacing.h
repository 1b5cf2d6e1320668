// How long things may take, as pure arithmetic on a clock that is handed in: chunks, progress
// events and checkpoints. None of it can change a result.
#pragma once

#include <cstdint>

namespace granary::run {

constexpr double kChunkSeconds = 0.05;            // stop requests are obeyed within two of these
constexpr double kProgressIntervalSeconds = 0.1;  // at most ten events a second
constexpr double kCheckpointCostShare = 0.02;     // of the run, at most

// Steps per chunk so that one takes about kChunkSeconds. Grows at most twofold a chunk, because the
// next phase may be slower than this one.
class ChunkPacer {
 public:
  std::uint64_t steps() const { return steps_; }
  void note(std::uint64_t steps_done, double seconds);

 private:
  std::uint64_t steps_ = 1;
};

class ProgressPacer {
 public:
  bool due(double now_s) const { return now_s >= next_s_; }
  void note(double now_s) { next_s_ = now_s + kProgressIntervalSeconds; }

 private:
  double next_s_ = 0;
};

class CheckpointPacer {
 public:
  CheckpointPacer(double interval_s, double now_s)
      : interval_s_(interval_s), next_s_(now_s + interval_s) {}
  bool due(double now_s) const { return now_s >= next_s_; }
  // It has waited for a mark of the run as long as it may.
  bool overdue(double now_s) const { return now_s >= next_s_ + interval_s_; }
  // A checkpoint that took `cost_s` is followed by another no sooner than its share of time allows;
  // an interval of 0 means after every chunk, whatever it costs.
  void note(double now_s, double cost_s);

 private:
  double interval_s_;
  double next_s_;
};

}  // namespace granary::run
