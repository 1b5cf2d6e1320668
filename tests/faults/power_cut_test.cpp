// The machine stops at a chosen file operation of a run that checkpoints after every chunk. Either
// everything written survives (only the process died), or everything that was not synced is lost.
// The next run on the same directory must end bitwise like an undisturbed one. All operations are
// tried, in strides that keep it quick (GRANARY_STRIDE; tests/long.sh uses 1).
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/faulty_file_system.h"
#include "tests/support/result_reader.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/toy_simulation.h"
#include "worker/run/run_task.h"
#include "worker/storage/verify.h"

namespace granary::run {
namespace {

using namespace granary::testing;

TaskSpec spec_in(const TemporaryDirectory& directory) {
  TaskSpec spec;
  spec.scene = toy_scene();
  spec.scene.set_replicates(2);
  spec.scene.mutable_output()->set_frames(8);
  spec.scene_key = "key";
  spec.engine_version = "1";
  spec.vector_path = "portable";
  spec.work_directory = directory / "run";
  spec.result_path = directory / "run" / "result.h5";
  spec.checkpoint_interval_s = 0;
  return spec;
}

TaskOutcome run(const TaskSpec& spec, storage::FileSystem& files) {
  const StopSignal stop{StopRequest::none};
  return run_task(spec, toy_factory(), {}, stop, files);
}

std::uint64_t stride() {
  const char* text = std::getenv("GRANARY_STRIDE");
  return text == nullptr ? 7 : std::strtoull(text, nullptr, 10);
}

class PowerCut : public ::testing::TestWithParam<bool> {};

TEST_P(PowerCut, at_any_operation_costs_time_and_nothing_else) {
  TemporaryDirectory calm;
  const TaskOutcome expected = run(spec_in(calm), storage::real_file_system());
  ASSERT_EQ(expected.outcome, v1::TaskFinished::COMPLETE) << expected.message;
  const StoredResult whole = read_result(calm / "run/result.h5");

  std::uint64_t at = 0;
  for (bool struck = true; struck; at += stride()) {
    TemporaryDirectory directory;
    const TaskSpec spec = spec_in(directory);
    FaultyFileSystem files(FaultyFileSystem::Fault::power_cut, at, directory / "scratch");
    const TaskOutcome cut = run(spec, files);
    struck = files.struck();
    EXPECT_EQ(cut.outcome, struck ? v1::TaskFinished::CRASHED : v1::TaskFinished::COMPLETE)
        << cut.message;
    std::filesystem::create_directories(spec.work_directory);
    if (GetParam()) files.lose_unsynced(spec.work_directory);
    const TaskOutcome again = run(spec, storage::real_file_system());
    ASSERT_EQ(again.outcome, v1::TaskFinished::COMPLETE)
        << "after operation " << at << ": " << again.message;
    EXPECT_EQ(again.result.state_hash(), expected.result.state_hash()) << "after operation " << at;
    EXPECT_EQ(again.result.cost().steps(), expected.result.cost().steps())
        << "after operation " << at;
    EXPECT_TRUE(storage::verify_result(spec.result_path).ok());
    const StoredResult result = read_result(spec.result_path);
    EXPECT_EQ(result.below("/frames"), whole.below("/frames")) << "after operation " << at;
    EXPECT_EQ(result.below("/values"), whole.below("/values")) << "after operation " << at;
  }
  EXPECT_GT(at, 100u);  // it did go through a whole run with its checkpoints
}

INSTANTIATE_TEST_SUITE_P(Fates, PowerCut, ::testing::Bool(), [](const auto& info) {
  return info.param ? "unsynced_is_lost" : "all_survives";
});

}  // namespace
}  // namespace granary::run
