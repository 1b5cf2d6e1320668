// The real engine process (with the toy inside), through its directory and its pipe.
#include "worker/run/engine_process.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>

#include "tests/support/engine_child.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/toy_simulation.h"
#include "worker/storage/checksum.h"
#include "worker/storage/verify.h"

namespace granary::run {
namespace {

using namespace granary::testing;

class EngineProcess : public ::testing::Test {
 protected:
  void assign(const v1::Scene& scene, double time_limit_s = 0) {
    v1::TaskAssignment assignment;
    *assignment.mutable_scene() = scene;
    assignment.set_time_limit_s(time_limit_s);
    std::ofstream out(directory / "task.pb", std::ios::binary);
    assignment.SerializeToOstream(&out);
  }
  v1::TaskFinished finished() const {
    v1::TaskFinished message;
    std::ifstream in(directory / "finished.pb", std::ios::binary);
    EXPECT_TRUE(in) << "no finished.pb";
    message.ParseFromIstream(&in);
    return message;
  }
  v1::Scene endless() const {
    v1::Scene scene = toy_scene("spin_us=100");
    scene.mutable_discharge()->set_duration_s(10000);
    return scene;
  }

  TemporaryDirectory directory;
};

TEST_F(EngineProcess, leaves_progress_result_and_outcome) {
  assign(toy_scene());
  EngineChild child(TOY_ENGINE, directory.path());
  const auto events = child.read_all_progress();
  EXPECT_EQ(child.wait(), 0);
  ASSERT_FALSE(events.empty());
  EXPECT_DOUBLE_EQ(events.back().fraction(), 1);
  const v1::TaskFinished message = finished();
  EXPECT_EQ(message.outcome(), v1::TaskFinished::COMPLETE) << message.message();
  EXPECT_TRUE(message.result().values().contains("f1_m"));
  EXPECT_FALSE(message.result().decisions().empty());
  EXPECT_FALSE(message.result().effects().empty());
  const auto digest = storage::sha256_of(storage::real_file_system(), directory / "result.h5");
  EXPECT_EQ(message.artifact().size_bytes(), digest.size_bytes);
  EXPECT_EQ(message.artifact().sha256(), digest.sha256);
  EXPECT_TRUE(storage::verify_result(directory / "result.h5").ok());
  EXPECT_FALSE(std::filesystem::exists(directory / "segment-000000"));
}

TEST_F(EngineProcess, sigterm_means_checkpoint_and_released_and_the_next_goes_on) {
  assign(endless());
  {
    EngineChild child(TOY_ENGINE, directory.path());
    ASSERT_TRUE(child.read_progress());
    child.signal(SIGTERM);
    EXPECT_EQ(child.wait(), 0);
  }
  EXPECT_EQ(finished().outcome(), v1::TaskFinished::RELEASED);
  EXPECT_TRUE(std::filesystem::exists(directory / "checkpoint"));

  v1::Scene rest = toy_scene();  // same key: knobs are no physics
  EngineChild child(TOY_ENGINE, directory.path());
  ASSERT_TRUE(child.read_progress());
  EXPECT_NE(child.log().find("resumed at t ="), std::string::npos) << child.log();
}

TEST_F(EngineProcess, sigint_means_cancelled_within_a_second) {
  assign(endless());
  EngineChild child(TOY_ENGINE, directory.path());
  ASSERT_TRUE(child.read_progress());
  const auto asked = std::chrono::steady_clock::now();
  child.signal(SIGINT);
  EXPECT_EQ(child.wait(), 0);
  const std::chrono::duration<double> latency = std::chrono::steady_clock::now() - asked;
  EXPECT_LT(latency.count(), 1.0);
  EXPECT_EQ(finished().outcome(), v1::TaskFinished::CANCELLED);
}

TEST_F(EngineProcess, ends_when_nobody_reads_its_progress_any_more) {
  assign(endless());
  EngineChild child(TOY_ENGINE, directory.path());
  ASSERT_TRUE(child.read_progress());
  child.close_pipe();
  EXPECT_EQ(child.wait(), 0);
  EXPECT_EQ(finished().outcome(), v1::TaskFinished::RELEASED);
}

TEST_F(EngineProcess, is_not_held_up_by_a_reader_that_sleeps) {
  assign(toy_scene("spin_us=200"));
  EngineChild child(TOY_ENGINE, directory.path());
  EXPECT_EQ(child.wait(), 0);  // nobody has read a byte
  EXPECT_EQ(finished().outcome(), v1::TaskFinished::COMPLETE);
}

TEST_F(EngineProcess, dies_with_its_parent) {
  assign(endless());
  const pid_t engine = spawn_through_dying_parent(TOY_ENGINE, directory.path());
  EXPECT_TRUE(is_gone_within(engine, std::chrono::seconds(10)));
}

TEST_F(EngineProcess, invalid_scene_is_an_error_with_its_field) {
  v1::Scene scene = toy_scene();
  scene.mutable_discharge()->mutable_particles()->set_diameter_min_m(-1);
  assign(scene);
  EngineChild child(TOY_ENGINE, directory.path());
  EXPECT_EQ(child.wait(), 0);
  EXPECT_EQ(finished().outcome(), v1::TaskFinished::ERROR);
  EXPECT_NE(finished().message().find("diameter_min_m"), std::string::npos) << finished().message();
}

TEST_F(EngineProcess, without_a_task_exits_with_2) {
  EngineChild child(TOY_ENGINE, directory.path());
  EXPECT_EQ(child.wait(), 2);
  EXPECT_FALSE(std::filesystem::exists(directory / "finished.pb"));
}

TEST_F(EngineProcess, obeys_the_time_limit) {
  assign(endless(), 0.2);
  EngineChild child(TOY_ENGINE, directory.path());
  EXPECT_EQ(child.wait(), 0);
  EXPECT_EQ(finished().outcome(), v1::TaskFinished::TIMED_OUT);
}

}  // namespace
}  // namespace granary::run
