#include "worker/run/run_record.h"

#include <gtest/gtest.h>

#include "worker/storage/storage_error.h"

namespace granary::run {
namespace {

RunRecord sample() {
  RunRecord record;
  FinishedReplicate replicate;
  replicate.seed = 12345678901234567890u;
  replicate.state_hash = "abc";
  replicate.values = {{"f1_m", "m", 1.5, {}, "basis"}, {"f4_m", "m", {}, {}, ""}};
  replicate.ledger.kinetic_j = 3;
  record.finished = {replicate, replicate};
  record.first.series = {
      {"cg", {core::make_column<double>("time_s", "s", std::vector<double>{1, 2})}}};
  record.first.warnings = {"one", "two"};
  record.first.effect_evaluations = {{"gas", 0}, {"cohesion", 17}};
  record.frames = {true, 0.25, 10, 7, 1.75, 1.5};
  record.mark.steps = 512;
  record.mark.frames.next_index = 6;
  record.recoveries = {{core::Cause::speed, core::Remedy::halve_time_step}};
  record.notes = {{"chute.time_step_s", 5e-6, "too fast"}};
  record.costs.cpu_s = 9.5;
  record.costs.steps = 1000;
  return record;
}

TEST(RunRecord, comes_back_whole_from_its_bytes) {
  const RunRecord back = decode_record(encode(sample()));
  ASSERT_EQ(back.finished.size(), 2u);
  EXPECT_EQ(back.finished[1].seed, 12345678901234567890u);
  EXPECT_EQ(back.finished[1].state_hash, "abc");
  EXPECT_EQ(back.finished[1].values[0].value, 1.5);
  EXPECT_FALSE(back.finished[1].values[0].error);
  EXPECT_EQ(back.finished[1].values[0].error_basis, "basis");
  EXPECT_FALSE(back.finished[1].values[1].value);
  EXPECT_EQ(back.finished[1].ledger.kinetic_j, 3);
  EXPECT_EQ(back.first.series.at(0).name, "cg");
  EXPECT_EQ(back.first.series[0].columns.at(0).as<double>()[1], 2);
  EXPECT_EQ(back.first.warnings, sample().first.warnings);
  EXPECT_EQ(back.first.effect_evaluations, sample().first.effect_evaluations);
  EXPECT_EQ(back.frames.next_index, 7u);
  EXPECT_EQ(back.frames.last_time_s, 1.5);
  EXPECT_EQ(back.mark.steps, 512u);
  EXPECT_EQ(back.mark.frames.next_index, 6u);
  EXPECT_EQ(back.recoveries.at(0).remedy, core::Remedy::halve_time_step);
  EXPECT_EQ(back.notes.at(0).path, "chute.time_step_s");
  EXPECT_EQ(back.notes[0].value, 5e-6);
  EXPECT_EQ(back.notes[0].evidence, "too fast");
  EXPECT_EQ(back.costs.cpu_s, 9.5);
  EXPECT_EQ(back.costs.steps, 1000u);
}

TEST(RunRecord, refuses_every_truncation) {
  const storage::Bytes bytes = encode(sample());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const storage::Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_THROW(decode_record(cut), storage::StorageError) << "cut at " << length;
  }
}

}  // namespace
}  // namespace granary::run
