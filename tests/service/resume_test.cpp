// What travels between workers: checkpoints, so that a lost worker costs seconds and not the run, and
// settled fillings, so that a speed sweep fills its bucket once.
#include <gmock/gmock.h>
#include <signal.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;

class Resume : public RealService {
 protected:
  // Several seconds of computing, so that a checkpoint every tenth of one is early.
  std::vector<std::string> medium_scene(std::vector<std::string> command) const {
    for (const char* word : {"--set", "discharge.time_step_s=4e-6"}) command.push_back(word);
    command.push_back(scene("discharge_small"));
    return command;
  }
  // Checkpoint files the server has committed for running jobs: looked up from outside, in its database.
  bool checkpoint_is_stored() const {
    const std::string count = "import sqlite3; print(sqlite3.connect('file:" + scratch.file("data/granary.db") +
                              "?mode=ro', uri=True).execute('SELECT count(*) FROM resume_file').fetchone()[0])";
    const Outputs outputs = run_program({.command = {"/usr/bin/env", "python3", "-c", count},
                                         .environment = {}, .input = "", .on_terminal = false});
    return outputs.exit_code == 0 && outputs.out != "0\n";
  }
  const std::map<std::string, std::string> eager_{{"GRANARY_CHECKPOINT_INTERVAL_S", "0.1"}};
};

TEST_F(Resume, a_killed_worker_s_job_continues_on_another_from_its_checkpoint_bit_for_bit) {
  const json undisturbed = [&] {
    start_worker();
    const Outputs outputs = granary(medium_scene({"run", "--format", "json"}));
    EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
    workers.back()->signal(SIGKILL);
    workers.back()->wait();
    return json::parse(outputs.out);
  }();
  Program& doomed = start_worker(1, eager_);
  const Outputs submitted = granary(medium_scene({"submit", "--fresh"}));
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  const std::string job = submitted.out.substr(0, submitted.out.find('\n'));
  ASSERT_TRUE(eventually([&] { return checkpoint_is_stored(); })) << "no checkpoint arrived";
  ASSERT_EQ(state(job), "running");
  doomed.signal(SIGKILL);
  doomed.wait();
  start_worker(1, eager_);
  ASSERT_TRUE(reaches(job, "complete"));
  const json resumed = json::parse(granary({"values", job, "--format", "json"}).out);
  EXPECT_EQ(status(job)["attempts"], 2);
  EXPECT_EQ(resumed["state_hash"], undisturbed["state_hash"]);
  EXPECT_EQ(resumed["values"], undisturbed["values"]);
  EXPECT_THAT(granary({"logs", job}).out, testing::HasSubstr("resum"));
}

TEST_F(Resume, a_speed_sweep_shares_one_filling) {
  start_worker();
  const std::string small = scene("discharge_small");
  const Outputs first = granary({"run", small, "--format", "json"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const Outputs second = granary({"run", small, "--set", "discharge.rotation_rad_per_s=7", "--format", "json"});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_GT(json::parse(second.out)["cost"]["reused_s"].get<double>(), 0);
  // The same as filling the bucket oneself, to the last bit.
  workers.back()->signal(SIGKILL);
  workers.back()->wait();
  const Outputs alone = run_program({.command = {GRANARY_BIN "/granary-worker", "--scene", small, "--set",
                                                 "discharge.rotation_rad_per_s=7", "--format", "json"},
                                     .environment = {}, .input = "", .on_terminal = false});
  EXPECT_EQ(json::parse(alone.out)["state_hash"], json::parse(second.out)["state_hash"]);
}

TEST_F(Resume, a_job_starts_from_the_filling_of_the_one_it_names) {
  start_worker();
  const std::string small = scene("discharge_small");
  const std::string faster = "discharge.rotation_rad_per_s=9.5";
  const Outputs submitted = granary({"submit", small, "--wait"});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  const json ordinary = json::parse(granary({"run", small, "--set", faster, "--fresh", "--format", "json"}).out);
  const auto from = [&](const std::string& job) {
    return granary({"run", small, "--set", faster, "--set", "discharge.filling=STORED", "--set",
                    "discharge.stored_filling=" + job, "--format", "json"});
  };
  const Outputs stored = from(json::parse(granary({"ls", "--format", "json"}).out).back()["job"]);
  ASSERT_EQ(stored.exit_code, 0) << stored.err;
  EXPECT_EQ(json::parse(stored.out)["state_hash"], ordinary["state_hash"]);
  EXPECT_GT(json::parse(stored.out)["cost"]["reused_s"].get<double>(), 0);
  const Outputs unknown = from("jobs/4711");
  EXPECT_NE(unknown.exit_code, 0);
  EXPECT_THAT(unknown.err, testing::HasSubstr("discharge.stored_filling: jobs/4711 does not exist"));
}

}  // namespace
}  // namespace granary::test
