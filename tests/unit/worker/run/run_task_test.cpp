#include "worker/run/run_task.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "tests/support/result_reader.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/toy_simulation.h"
#include "worker/storage/verify.h"

namespace granary::run {
namespace {

using namespace granary::testing;

class RunTask : public ::testing::Test {
 protected:
  TaskSpec spec_of(const v1::Scene& scene, const std::string& name = "r") {
    TaskSpec spec;
    spec.scene = scene;
    spec.scene_key = "key of the toy";
    spec.engine_version = "toy 1";
    spec.vector_path = "portable";
    spec.host = "here";
    spec.result_path = directory / (name + ".h5");
    spec.work_directory = directory / (name + ".parts");
    return spec;
  }
  TaskOutcome run(const TaskSpec& spec) { return run_task(spec, toy_factory(), callbacks, stop); }

  TemporaryDirectory directory;
  TaskCallbacks callbacks;
  StopSignal stop{StopRequest::none};
};

v1::Scene long_scene(const std::string& knobs = "") {
  v1::Scene scene = toy_scene("spin_us=200 " + knobs);
  scene.mutable_discharge()->set_duration_s(1000);
  return scene;
}

TEST_F(RunTask, gives_values_cost_ledger_and_a_file_that_verifies) {
  const TaskOutcome outcome = run(spec_of(toy_scene()));
  ASSERT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE) << outcome.message;
  const v1::Result& result = outcome.result;
  EXPECT_EQ(result.kind(), "discharge");
  EXPECT_TRUE(result.values().at("f1_m").has_value());
  EXPECT_EQ(result.values().at("f1_m").error_basis(), "single run: set replicates");
  EXPECT_EQ(result.values().at("f2_m").error(), 0.5);
  EXPECT_FALSE(result.values().at("f4_m").has_value());
  EXPECT_EQ(result.values().at("f4_m").error_basis(), "nothing landed");
  EXPECT_EQ(result.cost().steps(), 1100u);
  EXPECT_EQ(result.cost().particle_steps(), 8800u);
  EXPECT_GT(result.cost().cpu_s(), 0);
  EXPECT_GT(result.cost().peak_rss_bytes(), 1u << 20);
  EXPECT_DOUBLE_EQ(result.cost().contacts_per_particle(), 9.0 / 8);
  EXPECT_LT(result.ledger().remainder_ratio(), 1e-12);
  EXPECT_EQ(result.state_hash().size(), 32u);

  const storage::VerifyReport report = storage::verify_result(directory / "r.h5");
  EXPECT_TRUE(report.ok()) << report.problems.front();
  EXPECT_EQ(report.frame_count, 101u);
  EXPECT_TRUE(outcome.published);
}

TEST_F(RunTask, file_and_message_say_the_same) {
  const TaskOutcome outcome = run(spec_of(toy_scene()));
  const StoredResult stored = read_result(directory / "r.h5");
  EXPECT_EQ(stored.datasets.at("/values/f1_m").as<double>().at(0),
            outcome.result.values().at("f1_m").value());
  EXPECT_EQ(stored.texts.at("/provenance@state_hash"), outcome.result.state_hash());
  EXPECT_EQ(stored.numbers.at("/provenance@steps"), 1100);
  EXPECT_EQ(stored.datasets.at("/series/energy/time_s").as<double>().size(), 110u);
  EXPECT_EQ(stored.datasets.at("/provenance/warnings").text(), "only a toy");
  EXPECT_EQ(stored.numbers.at("/frames/000000@time_s"), 0);
}

TEST_F(RunTask, is_bitwise_the_same_with_and_without_files_frames_and_checkpoints) {
  TaskSpec bare = spec_of(toy_scene());
  bare.result_path.clear();
  TaskSpec busy = spec_of(toy_scene(), "busy");
  busy.checkpoint_interval_s = 0;
  busy.scene.mutable_output()->set_frames(1000);
  const std::string hash = run(spec_of(toy_scene())).result.state_hash();
  EXPECT_EQ(run(bare).result.state_hash(), hash);
  EXPECT_EQ(run(busy).result.state_hash(), hash);
}

// Released again and again, at whatever step the clock happens to show, until it is through.
TEST_F(RunTask, resumed_many_times_ends_bitwise_like_an_undisturbed_run) {
  v1::Scene slow = toy_scene("spin_us=300");
  slow.set_replicates(2);
  TaskSpec undisturbed = spec_of(slow, "whole");
  const TaskOutcome expected = run(undisturbed);

  const TaskSpec spec = spec_of(slow, "pieces");
  TaskOutcome outcome;
  int attempts = 0;
  for (outcome.outcome = v1::TaskFinished::RELEASED; outcome.outcome == v1::TaskFinished::RELEASED;
       ++attempts) {
    ASSERT_LT(attempts, 1000);
    stop = StopRequest::none;
    int events = 0;
    callbacks.progress = [&](const v1::Progress&) {
      if (++events == 2) stop = StopRequest::release;  // a tenth of a second after the first
    };
    outcome = run(spec);
  }
  ASSERT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE) << outcome.message;
  EXPECT_GE(attempts, 3);
  EXPECT_EQ(outcome.result.state_hash(), expected.result.state_hash());
  EXPECT_EQ(outcome.result.cost().steps(), expected.result.cost().steps());
  EXPECT_EQ(outcome.result.cost().particle_steps(), expected.result.cost().particle_steps());
  const StoredResult a = read_result(undisturbed.result_path);
  const StoredResult b = read_result(spec.result_path);
  for (const char* part : {"/frames", "/series", "/fields", "/values", "/ledger", "/replicates"}) {
    EXPECT_FALSE(a.below(part).empty()) << part;
    EXPECT_EQ(a.below(part), b.below(part)) << part;
  }
}

// Another machine gets the checkpoint and the sealed segments, and nothing else.
TEST_F(RunTask, goes_on_bitwise_where_its_checkpoint_and_segments_are_taken_to) {
  const TaskSpec whole = spec_of(toy_scene(), "whole");
  const TaskOutcome expected = run(whole);
  const TaskSpec here = spec_of(toy_scene("spin_us=300"), "here");
  int events = 0;
  callbacks.progress = [&](const v1::Progress&) {
    if (++events == 2) stop = StopRequest::release;
  };
  ASSERT_EQ(run(here).outcome, v1::TaskFinished::RELEASED);
  const TaskSpec there = spec_of(toy_scene(), "there");
  std::filesystem::create_directory(there.work_directory);
  for (const auto& file : std::filesystem::directory_iterator(here.work_directory))
    if (const auto name = file.path().filename(); !name.has_extension())
      std::filesystem::copy(file.path(), there.work_directory / name);
  std::filesystem::remove_all(here.work_directory);

  stop = StopRequest::none;
  callbacks = {};
  std::string log;
  callbacks.log = [&](std::string_view line) { log += line; };
  const TaskOutcome outcome = run(there);
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE);
  EXPECT_NE(log.find("resumed at"), std::string::npos) << log;
  EXPECT_EQ(outcome.result.state_hash(), expected.result.state_hash());
  EXPECT_EQ(read_result(there.result_path).below("/frames"),
            read_result(whole.result_path).below("/frames"));
}

TEST_F(RunTask, checkpoint_of_another_scene_is_refused_and_the_run_starts_over) {
  const std::string hash = run(spec_of(toy_scene(), "clean")).result.state_hash();
  TaskSpec other = spec_of(toy_scene("spin_us=50"));
  other.scene_key = "another key";
  callbacks.progress = [&](const v1::Progress&) { stop = StopRequest::release; };
  ASSERT_EQ(run(other).outcome, v1::TaskFinished::RELEASED);

  stop = StopRequest::none;
  callbacks.progress = [](const v1::Progress&) {};
  std::string log;
  callbacks.log = [&](std::string_view line) { log += line; };
  const TaskOutcome outcome = run(spec_of(toy_scene()));
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE);
  EXPECT_NE(log.find("belongs to another scene"), std::string::npos) << log;
  EXPECT_EQ(outcome.result.state_hash(), hash);
}

TEST_F(RunTask, other_output_settings_do_not_resume_each_others_frames) {
  TaskSpec spec = spec_of(toy_scene("spin_us=50"));
  callbacks.progress = [&](const v1::Progress&) { stop = StopRequest::release; };
  ASSERT_EQ(run(spec).outcome, v1::TaskFinished::RELEASED);
  stop = StopRequest::none;
  callbacks.progress = [](const v1::Progress&) {};
  spec.scene.mutable_output()->set_frames(10);
  ASSERT_EQ(run(spec).outcome, v1::TaskFinished::COMPLETE);
  EXPECT_EQ(storage::verify_result(spec.result_path).frame_count, 11u);
}

TEST_F(RunTask, replicates_give_error_bars_and_are_stored_each) {
  v1::Scene scene = toy_scene();
  const double single = run(spec_of(scene)).result.values().at("f1_m").value();
  scene.set_replicates(4);
  const TaskOutcome outcome = run(spec_of(scene, "four"));
  const v1::Quantity& f1 = outcome.result.values().at("f1_m");
  EXPECT_EQ(f1.error_basis(), "95 % t-interval of 4 replicates");
  const StoredResult stored = read_result(directory / "four.h5");
  double sum = 0;
  for (const char* index : {"000", "001", "002", "003"})
    sum += stored.datasets.at(std::string("/replicates/") + index + "/f1_m").as<double>().at(0);
  EXPECT_NEAR(f1.value(), sum / 4, 1e-15);
  EXPECT_EQ(stored.datasets.at("/replicates/000/f1_m").as<double>().at(0), single);
  EXPECT_NE(stored.datasets.at("/replicates/001/f1_m").as<double>().at(0), single);
  EXPECT_EQ(outcome.result.cost().steps(), 4 * 1100u);
  EXPECT_EQ(storage::verify_result(directory / "four.h5").frame_count, 101u);  // of the first
}

TEST_F(RunTask, rejection_is_unstable_with_reason_ids_and_advice_and_no_values) {
  const TaskOutcome outcome = run(spec_of(toy_scene("reject_at_step=500")));
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::UNSTABLE);
  EXPECT_EQ(
      outcome.message,
      "unstable at t = 0.4 s: the toy was told to give up (particle 3, 5); try: do not tell it");
  EXPECT_TRUE(outcome.result.values().empty());
  EXPECT_EQ(outcome.result.cost().steps(), 500u);
  const storage::VerifyReport report = storage::verify_result(directory / "r.h5");
  EXPECT_TRUE(report.ok()) << report.problems.front();
  EXPECT_EQ(report.frame_count, 41u);  // up to the failure
  EXPECT_EQ(read_result(directory / "r.h5").texts.at("@state"), "unstable");
}

TEST_F(RunTask, nan_in_the_state_is_unstable_and_never_stored) {
  for (const char* knob : {"nan_at_step=0", "nan_at_step=500", "nan_at_step=1099"}) {
    const TaskOutcome outcome = run(spec_of(toy_scene(knob)));
    EXPECT_EQ(outcome.outcome, v1::TaskFinished::UNSTABLE) << knob;
    EXPECT_NE(outcome.message.find("is not finite (particle 0)"), std::string::npos)
        << outcome.message;
    EXPECT_TRUE(std::isfinite(outcome.result.ledger().remainder_ratio()));
    EXPECT_TRUE(storage::verify_result(directory / "r.h5").ok()) << knob;
  }
}

TEST_F(RunTask, nan_in_a_value_is_withheld_with_its_reason) {
  const TaskOutcome outcome = run(spec_of(toy_scene("nan_value")));
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::COMPLETE);
  EXPECT_FALSE(outcome.result.values().at("f1_m").has_value());
  EXPECT_EQ(outcome.result.values().at("f1_m").error_basis(), "withheld: not a finite number");
  EXPECT_FALSE(read_result(directory / "r.h5").datasets.at("/values/f1_m").has_data);
}

TEST_F(RunTask, cancel_ends_it_within_a_second) {
  TaskOutcome outcome;
  std::atomic<bool> running = false;
  callbacks.progress = [&](const v1::Progress&) { running = true; };
  std::thread thread([&] { outcome = run(spec_of(long_scene())); });
  while (!running) std::this_thread::yield();
  const auto asked = std::chrono::steady_clock::now();
  stop = StopRequest::cancel;
  thread.join();
  const std::chrono::duration<double> latency = std::chrono::steady_clock::now() - asked;
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::CANCELLED);
  EXPECT_LT(latency.count(), 1.0);
  EXPECT_FALSE(std::filesystem::exists(directory / "r.h5"));
}

TEST_F(RunTask, time_limit_ends_it) {
  TaskSpec spec = spec_of(long_scene());
  spec.time_limit_s = 0.2;
  const TaskOutcome outcome = run(spec);
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::TIMED_OUT);
}

TEST_F(RunTask, engine_that_does_not_advance_is_an_error_and_not_a_hang) {
  const TaskOutcome outcome = run(spec_of(toy_scene("stuck")));
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::ERROR);
  EXPECT_EQ(outcome.message, "the engine does not advance");
}

TEST_F(RunTask, scene_without_engine_is_an_error_with_the_factorys_words) {
  const SimulationFactory factory = [](const v1::Scene&,
                                       const core::State*) -> std::unique_ptr<core::Simulation> {
    throw std::runtime_error("chutes are not available");
  };
  const TaskOutcome outcome = run_task(spec_of(toy_scene()), factory, callbacks, stop);
  EXPECT_EQ(outcome.outcome, v1::TaskFinished::ERROR);
  EXPECT_EQ(outcome.message, "chutes are not available");
}

TEST_F(RunTask, progress_is_throttled_rises_and_ends_at_the_whole) {
  v1::Scene scene = toy_scene("spin_us=500");  // 1100 steps: 0.55 s
  std::vector<v1::Progress> events;
  callbacks.progress = [&](const v1::Progress& progress) { events.push_back(progress); };
  const TaskOutcome outcome = run(spec_of(scene));
  ASSERT_GE(events.size(), 2u);
  EXPECT_LE(events.size(), 10 * outcome.result.cost().wall_s() + 2);  // the first and the last
  for (std::size_t i = 1; i < events.size(); ++i)
    EXPECT_GE(events[i].fraction(), events[i - 1].fraction());
  EXPECT_DOUBLE_EQ(events.back().fraction(), 1);
  EXPECT_EQ(events.back().particles(), 8u);
  EXPECT_EQ(events.back().phase(), "swinging");
  EXPECT_GT(events.back().ns_per_particle_step(), 0);
  EXPECT_TRUE(events.back().current_values().contains("f1_m"));
}

TEST_F(RunTask, stored_filling_saves_its_work_and_changes_no_bit) {
  TaskSpec maker = spec_of(toy_scene("spin_us=20"));
  maker.filling_key = "a filling";
  maker.filling_output = directory / "filling";
  const TaskOutcome first = run(maker);
  ASSERT_TRUE(std::filesystem::exists(maker.filling_output));

  TaskSpec user = spec_of(toy_scene("spin_us=20"), "user");
  user.filling_key = "a filling";
  user.filling_input = maker.filling_output;
  const TaskOutcome second = run(user);
  EXPECT_EQ(second.result.state_hash(), first.result.state_hash());
  // 100 of 1100 steps of 20 us.
  EXPECT_GT(second.result.cost().reused_s(), 0.5 * 100 * 20e-6);
  EXPECT_GT(second.result.cost().cpu_s(), second.result.cost().reused_s());

  user.filling_key = "another filling";
  const TaskOutcome third = run(user);
  EXPECT_EQ(third.result.cost().reused_s(), 0);
  EXPECT_EQ(third.result.state_hash(), first.result.state_hash());
}

TEST_F(RunTask, stores_only_the_columns_asked_for) {
  v1::Scene scene = toy_scene();
  scene.mutable_output()->add_fields("id");
  run(spec_of(scene));
  const StoredResult stored = read_result(directory / "r.h5");
  EXPECT_TRUE(stored.datasets.contains("/frames/000000/id"));
  EXPECT_FALSE(stored.datasets.contains("/frames/000000/position_m"));
}

}  // namespace
}  // namespace granary::run
