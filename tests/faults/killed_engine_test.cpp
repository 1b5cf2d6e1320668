// A real engine process is killed with SIGKILL again and again at random moments and started again
// on its directory, as a worker does. In the end there is one result, bitwise that of an
// undisturbed run.
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <thread>

#include "tests/support/engine_child.h"
#include "tests/support/result_reader.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/toy_simulation.h"
#include "worker/storage/verify.h"

namespace granary::run {
namespace {

using namespace granary::testing;

void assign(const std::filesystem::path& directory, const v1::Scene& scene) {
  v1::TaskAssignment assignment;
  *assignment.mutable_scene() = scene;
  std::ofstream out(directory / "task.pb", std::ios::binary);
  assignment.SerializeToOstream(&out);
}

std::optional<v1::TaskFinished> finished_in(const std::filesystem::path& directory) {
  std::ifstream in(directory / "finished.pb", std::ios::binary);
  v1::TaskFinished finished;
  if (!in || !finished.ParseFromIstream(&in)) return std::nullopt;
  return finished;
}

// About 2200 steps of 100 us in two replicates.
v1::Scene scene_to_kill() {
  v1::Scene scene = toy_scene("spin_us=100");
  scene.set_replicates(2);
  return scene;
}

TEST(KilledEngine, ends_bitwise_like_an_undisturbed_one_however_often_it_is_killed) {
  setenv("GRANARY_CHECKPOINT_INTERVAL_S", "0",
         1);  // after every chunk: many moments to be killed in
  TemporaryDirectory calm;
  assign(calm.path(), scene_to_kill());
  EngineChild undisturbed(TOY_ENGINE, calm.path());
  ASSERT_EQ(undisturbed.wait(), 0);
  const auto expected = finished_in(calm.path());
  ASSERT_TRUE(expected);

  TemporaryDirectory stormy;
  assign(stormy.path(), scene_to_kill());
  std::mt19937 random(7);
  int kills = 0;
  for (int attempt = 0; !finished_in(stormy.path()); ++attempt) {
    ASSERT_LT(attempt, 200) << "no progress between kills";
    EngineChild child(TOY_ENGINE, stormy.path());
    // Lives grow, so that even on a disk that takes long to sync one of them gets through.
    std::uniform_int_distribution<> life_ms(5, 60 + 5 * attempt);
    std::this_thread::sleep_for(std::chrono::milliseconds(life_ms(random)));
    child.signal(SIGKILL);
    if (child.wait() == -SIGKILL) ++kills;
  }
  unsetenv("GRANARY_CHECKPOINT_INTERVAL_S");
  EXPECT_GE(kills, 3);
  const auto outcome = finished_in(stormy.path());
  ASSERT_EQ(outcome->outcome(), v1::TaskFinished::COMPLETE) << outcome->message();
  EXPECT_EQ(outcome->result().state_hash(), expected->result().state_hash());
  EXPECT_EQ(outcome->result().cost().steps(), expected->result().cost().steps());
  EXPECT_TRUE(storage::verify_result(stormy / "result.h5").ok());
  const StoredResult a = read_result(calm / "result.h5");
  const StoredResult b = read_result(stormy / "result.h5");
  for (const char* part : {"/frames", "/series", "/values", "/replicates"})
    EXPECT_EQ(a.below(part), b.below(part)) << part;
}

TEST(CrashingEngine, leaves_no_outcome_and_can_be_started_again) {
  TemporaryDirectory directory;
  assign(directory.path(), toy_scene("crash_at_step=500"));
  EngineChild child(TOY_ENGINE, directory.path());
  EXPECT_EQ(child.wait(), -SIGABRT);
  EXPECT_FALSE(finished_in(directory.path()));
  assign(directory.path(), toy_scene());
  EngineChild again(TOY_ENGINE, directory.path());
  EXPECT_EQ(again.wait(), 0);
  EXPECT_EQ(finished_in(directory.path())->outcome(), v1::TaskFinished::COMPLETE);
}

}  // namespace
}  // namespace granary::run
