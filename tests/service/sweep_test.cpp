// Sweeps over real programs: every combination runs once, is answered from the store the second
// time, and survives kill -9 of the server.
#include <gmock/gmock.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Sweep : public RealService {
 protected:
  std::vector<std::string> sweep_arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"sweep",  scene("discharge_small"),
                                          "--set",  "discharge.particles.count=60",
                                          "--vary", "discharge.rotation_rad_per_s=8,9,10",
                                          "--vary", "discharge.friction_pp_deg=20,30"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  json rows(const std::vector<std::string>& arguments) {
    const Outputs outputs = granary(arguments);
    EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
    return json::parse(outputs.out);
  }
  json history(const std::string& study) {
    return rows({"study", "history", study, "--format", "json"});
  }
  std::string study_state(const std::string& study) {
    for (const json& row : rows({"study", "ls", "--format", "json"}))
      if (row["study"] == study) return row["state"];
    return "";
  }
};

TEST_F(Sweep, runs_every_combination_and_prints_its_trials) {
  start_worker(2);
  const Outputs outputs =
      granary(sweep_arguments({"--wait", "--format", "json", "--name", "speeds"}));
  ASSERT_EQ(outputs.exit_code, 0) << outputs.err;
  std::istringstream lines(outputs.out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const json trial = json::parse(line);
    EXPECT_EQ(trial["number"], count + 1);
    EXPECT_EQ(trial["state"], "complete");
    EXPECT_TRUE(trial["values"]["f1_m"].contains("value")) << line;
    EXPECT_EQ(trial["inputs"].size(), 2u);
  }
  EXPECT_EQ(count, 6);
  const json studies = rows({"study", "ls", "--format", "json"});
  EXPECT_EQ(studies[0]["title"], "speeds");
  EXPECT_EQ(studies[0]["state"], "complete");
  EXPECT_EQ(status("jobs/1")["study"], "studies/1");
  const json asked =
      rows({"query",
            "SELECT t.number, d.\"discharge.rotation_rad_per_s\" AS omega, d.f1_m FROM "
            "trials t JOIN discharge_values d USING (job) WHERE t.study = 'studies/1' "
            "ORDER BY t.number",
            "--format", "json"});
  ASSERT_EQ(asked.size(), 6u);
  EXPECT_EQ(asked[5]["omega"], 10.0);
  EXPECT_TRUE(asked[5]["f1_m"].is_number());
}

TEST_F(Sweep, the_second_one_runs_nothing) {
  Program& worker = start_worker(2);
  ASSERT_EQ(granary(sweep_arguments({"--wait"})).exit_code, 0);
  worker.signal(SIGKILL);  // nobody can compute any more
  worker.wait();
  const Outputs again = granary(sweep_arguments({"--wait", "--format", "csv"}));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const json tasks = rows({"query", "SELECT count(*) AS n FROM tasks", "--format", "json"});
  EXPECT_EQ(tasks[0]["n"], 6);
  EXPECT_EQ(rows({"study", "ls", "--format", "json"})[0]["reused_trials"], 6);
}

TEST_F(Sweep, survives_kill_9_of_the_server_again_and_again) {
  start_worker(2);
  const Outputs submitted = granary({"sweep", scene("discharge_small"), "--set",
                                     "discharge.particles.count=60", "--vary", "seed=1:20:20"});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  const std::string study = submitted.out.substr(0, submitted.out.find('\n'));
  for (const int ended : {2, 7, 13}) {
    ASSERT_TRUE(eventually(
        [&] {
          return rows(
                     {"query", "SELECT ended_trials AS n FROM studies", "--format", "json"})[0]["n"]
                     .get<int>() >= ended;
        },
        std::chrono::seconds(60)));
    kill_server();
    start_server();
  }
  ASSERT_TRUE(
      eventually([&] { return study_state(study) == "complete"; }, std::chrono::seconds(60)));
  const json trials = history(study);
  ASSERT_EQ(trials.size(), 20u);
  std::set<std::string> jobs;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    EXPECT_EQ(trials[i]["number"], i + 1);
    EXPECT_EQ(trials[i]["state"], "complete") << trials[i];
    EXPECT_EQ(trials[i]["inputs"]["seed"], std::to_string(i + 1));
    jobs.insert(trials[i]["job"].get<std::string>());
  }
  EXPECT_EQ(jobs.size(), 20u);
  const json doubled =
      rows({"query", "SELECT count(*) AS n FROM jobs WHERE study = '" + study + "'", "--format",
            "json"});
  EXPECT_EQ(doubled[0]["n"], 20) << "a trial has one job";
}

TEST_F(Sweep, is_refused_as_a_whole_when_one_point_is_wrong) {
  const Outputs outputs =
      granary({"sweep", scene("discharge_small"), "--vary", "discharge.friction_pp_deg=20,120"});
  EXPECT_EQ(outputs.exit_code, 2);
  EXPECT_THAT(outputs.err, HasSubstr("friction_pp_deg"));
  EXPECT_EQ(rows({"ls", "--format", "json"}).size(), 0u);
  EXPECT_EQ(granary({"sweep", scene("discharge_small"), "--vary", "nonsense"}).exit_code, 2);
  EXPECT_EQ(granary({"study", "history", "studies/9"}).exit_code, 3);
  EXPECT_EQ(granary({"watch", "studies/9"}).exit_code, 3);
}

TEST_F(Sweep, pause_resume_and_cancel_do_what_they_say) {
  const Outputs submitted = granary(sweep_arguments());
  ASSERT_EQ(submitted.out, "studies/1\n") << submitted.err;
  EXPECT_EQ(rows({"study", "pause", "1", "--format", "json"})["state"], "paused");
  EXPECT_EQ(rows({"study", "resume", "studies/1", "--format", "json"})["state"], "running");
  EXPECT_EQ(granary({"study", "extend", "studies/1", "--budget", "9"}).exit_code, 2);
  EXPECT_EQ(rows({"study", "cancel", "studies/1", "--format", "json"})["state"], "cancelled");
  EXPECT_EQ(state("jobs/1"), "cancelled");
  EXPECT_EQ(granary({"watch", "studies/1"}).exit_code, 7);
}

TEST_F(Sweep, samples_are_a_latin_hypercube_over_the_range) {
  const Outputs submitted = granary({"sweep", scene("discharge_small"), "--vary",
                                     "discharge.rotation_rad_per_s=8,12", "--samples", "5"});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  const json trials = history("studies/1");
  ASSERT_EQ(trials.size(), 5u);
  std::set<int> strata;
  for (const json& trial : trials)
    strata.insert(static_cast<int>(
        (std::stod(trial["inputs"]["discharge.rotation_rad_per_s"].get<std::string>()) - 8) / 0.8));
  EXPECT_EQ(strata.size(), 5u);
}

}  // namespace
}  // namespace granary::test
