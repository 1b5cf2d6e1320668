#include "worker/run/pacing.h"

#include <gtest/gtest.h>

namespace granary::run {
namespace {

// An engine whose step takes `step_s`: the chunk after `chunks` chunks.
double chunk_seconds_after(ChunkPacer& pacer, double step_s, int chunks) {
  double seconds = 0;
  for (int i = 0; i < chunks; ++i) {
    const std::uint64_t steps = pacer.steps();
    seconds = static_cast<double>(steps) * step_s;
    pacer.note(steps, seconds);
  }
  return static_cast<double>(pacer.steps()) * step_s;
}

TEST(ChunkPacer, settles_at_its_wall_time_whatever_a_step_costs) {
  for (const double step_s : {1e-7, 1e-5, 1e-3, 0.04}) {
    ChunkPacer pacer;
    const double seconds = chunk_seconds_after(pacer, step_s, 40);
    EXPECT_LE(seconds, kChunkSeconds * 1.0001) << step_s;
    EXPECT_GE(seconds, kChunkSeconds / 2) << step_s;
  }
}

TEST(ChunkPacer, never_stalls_on_steps_longer_than_a_chunk) {
  ChunkPacer pacer;
  chunk_seconds_after(pacer, 3.0, 5);
  EXPECT_EQ(pacer.steps(), 1u);
}

TEST(ChunkPacer, adapts_to_dearer_steps_within_one_chunk) {
  ChunkPacer pacer;
  chunk_seconds_after(pacer, 1e-5, 40);
  EXPECT_LE(chunk_seconds_after(pacer, 1e-4, 1), kChunkSeconds * 1.0001);
}

TEST(ChunkPacer, ignores_chunks_cut_short) {
  ChunkPacer pacer;
  chunk_seconds_after(pacer, 1e-5, 40);
  const std::uint64_t steps = pacer.steps();
  pacer.note(1, 1e-3);  // one step up to a frame, with its overhead
  EXPECT_EQ(pacer.steps(), steps);
}

TEST(ProgressPacer, lets_ten_events_a_second_through) {
  ProgressPacer pacer;
  int events = 0;
  for (int millisecond = 0; millisecond < 3000; ++millisecond) {
    const double now_s = 1000 + 1e-3 * millisecond;
    if (!pacer.due(now_s)) continue;
    pacer.note(now_s);
    ++events;
  }
  EXPECT_LE(events, 30);
  EXPECT_GE(events, 29);
}

TEST(CheckpointPacer, keeps_its_interval_while_checkpoints_are_cheap) {
  CheckpointPacer pacer(20, 100);
  EXPECT_FALSE(pacer.due(119.9));
  EXPECT_TRUE(pacer.due(120));
  pacer.note(120, 0.1);
  EXPECT_FALSE(pacer.due(139.9));
  EXPECT_TRUE(pacer.due(140));
}

TEST(CheckpointPacer, stretches_so_that_dear_ones_cost_two_percent) {
  CheckpointPacer pacer(20, 0);
  pacer.note(22, 2);
  EXPECT_FALSE(pacer.due(22 + 99.9));  // 2 s in 100 s
  EXPECT_TRUE(pacer.due(22 + 100.0));
}

}  // namespace
}  // namespace granary::run
