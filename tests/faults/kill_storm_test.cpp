// Claim: whatever is killed at whatever moment, every accepted job ends in exactly one stored result,
// the same to the last bit as that of an undisturbed run.
// Method: mixed jobs are submitted with request ids while server and workers are killed with SIGKILL
// at random moments and started again; then everything that is stored is counted and compared.
// GRANARY_STORM_KILLS and GRANARY_STORM_JOBS set the size (tests/long.sh: 200 and 500),
// GRANARY_STORM_SEED the moments.
#include <signal.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;

int from_environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

class KillStorm : public RealService {
 protected:
  static constexpr std::chrono::minutes kPatience{20};

  void SetUp() override {
    RealService::SetUp();
    for (int i = 0; i < 2; ++i) start_worker(1, eager_);
  }

  // Short ones, long ones with checkpoints, both kinds.
  std::vector<std::string> variant(int number) const {
    const std::string seed = "seed=" + std::to_string(number);
    switch (number % 4) {
      case 0: return {scene("discharge_small"), "--set", seed};
      case 1: return {scene("discharge_small"), "--set", seed, "--set", "discharge.time_step_s=2e-5"};
      case 2: return {scene("chute_small"), "--set", seed, "--set", "chute.duration_s=0.05", "--set",
                      "chute.sample_start_s=0.02"};
      default: return {scene("discharge_small"), "--set", seed, "--set", "discharge.rotation_rad_per_s=8"};
    }
  }

  std::map<int, std::string> undisturbed_hashes() {
    std::map<int, std::string> hashes;
    for (int number = 0; number < kVariants; ++number) {
      std::vector<std::string> command = variant(number);
      command.insert(command.begin(), {GRANARY_BIN "/granary-worker", "--scene"});
      command.insert(command.end(), {"--format", "json"});
      const Outputs outputs =
          run_program({.command = command, .environment = {}, .input = "", .on_terminal = false});
      EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
      hashes[number] = json::parse(outputs.out)["state_hash"];
    }
    return hashes;
  }

  // The same request id until the server says yes: a lost reply must not make a second job.
  std::string submit_stubbornly(int number) {
    std::vector<std::string> command = variant(number % kVariants);
    command.insert(command.begin(), {"submit", "--request-id", "storm-" + std::to_string(number)});
    if (number % 3 != 0) command.push_back("--fresh");
    Outputs outputs;
    eventually([&] { return (outputs = granary(command)).exit_code == 0; }, kPatience);
    EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
    return outputs.out.substr(0, outputs.out.find('\n'));
  }

  void kill_and_restart(std::size_t victim) {
    if (victim == 0) {
      kill_server();
      start_server();
      return;
    }
    workers[victim - 1]->signal(SIGKILL);
    workers[victim - 1]->wait();
    start_worker(1, eager_);
    std::swap(workers[victim - 1], workers.back());
    workers.pop_back();
  }

  json ask_database(const std::string& sql) {
    const std::string program =
        "import sqlite3,json; print(json.dumps(sqlite3.connect('file:" + scratch.file("data/granary.db") +
        "?mode=ro', uri=True).execute(\"" + sql + "\").fetchall()))";
    return json::parse(run_program({.command = {"/usr/bin/env", "python3", "-c", program},
                                    .environment = {}, .input = "", .on_terminal = false})
                           .out);
  }

  static constexpr int kVariants = 8;
  const std::map<std::string, std::string> eager_{{"GRANARY_CHECKPOINT_INTERVAL_S", "0.1"}};
};

TEST_F(KillStorm, every_job_ends_once_with_the_hash_of_an_undisturbed_run) {
  const int kills = from_environment("GRANARY_STORM_KILLS", 8);
  const int count = from_environment("GRANARY_STORM_JOBS", 24);
  const int seed = from_environment("GRANARY_STORM_SEED", 1);
  SCOPED_TRACE("GRANARY_STORM_SEED=" + std::to_string(seed));
  const std::map<int, std::string> expected = undisturbed_hashes();

  std::vector<std::string> jobs(static_cast<std::size_t>(count));
  std::thread submitter([&] {
    for (int i = 0; i < count; ++i) jobs[static_cast<std::size_t>(i)] = submit_stubbornly(i);
  });
  std::mt19937 random(static_cast<unsigned>(seed));
  for (int i = 0; i < kills; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 900));  // the moment is the test
    kill_and_restart(random() % 3);
  }
  submitter.join();

  const auto unfinished = [&] {
    return ask_database("SELECT count(*) FROM job WHERE state IN (1, 2)")[0][0].get<int>();
  };
  ASSERT_TRUE(eventually([&] { return unfinished() == 0; }, kPatience));
  EXPECT_EQ(std::set<std::string>(jobs.begin(), jobs.end()).size(), jobs.size()) << "two requests share a job";
  EXPECT_EQ(ask_database("SELECT count(*) FROM job")[0][0], count) << "a job was made twice";
  for (int i = 0; i < count; ++i) {
    const std::string& job = jobs[static_cast<std::size_t>(i)];
    const json values = json::parse(granary({"values", job, "--format", "json"}).out);
    EXPECT_EQ(values["state"], "complete") << job << values.dump();
    EXPECT_EQ(values["state_hash"], expected.at(i % kVariants)) << job;
    const std::string file = scratch.file("result.h5");
    ASSERT_EQ(granary({"fetch", job, "-o", file}).exit_code, 0) << job;
    EXPECT_EQ(granary({"verify", file}).exit_code, 0) << job;
    ASSERT_EQ(::unlink(file.c_str()), 0);
  }
  EXPECT_EQ(ask_database("SELECT job FROM task WHERE outcome = 'complete' GROUP BY job HAVING count(*) > 1").size(), 0u);
  RecordProperty("executions", ask_database("SELECT count(*) FROM task")[0][0].get<int>());
}

}  // namespace
}  // namespace granary::test
