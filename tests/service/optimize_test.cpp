// Optimizations over real programs, and what kill -9 of the server does to them: nothing.
#include <gmock/gmock.h>

#include <fstream>
#include <random>
#include <thread>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Optimize : public RealService {
 protected:
  // 40 disks: a trial takes some hundredths of a second.
  std::string study_file(const std::string& method, int budget) {
    return scratch.write("study.txtpb", "scene_file: \"" + scene("discharge_small") + R"("
set: "discharge.particles.count=40"
set: "discharge.bucket.shape=BEZIER"
set: "discharge.bucket.x2_m=-0.02" set: "discharge.bucket.x3_m=-0.04" set: "discharge.bucket.x4_m=-0.06"
seed: 3
optimize {
  method: )" + method + R"(
  vary { path: "discharge.bucket.x2_m" minimum: -0.1 maximum: 0 }
  vary { path: "discharge.bucket.x4_m" minimum: -0.1 maximum: 0 }
  objective { value: "f1_m" weight: 1 goal: MAXIMISE }
  constraint { value: "fill_ratio" minimum: 0.5 }
  budget: )" + std::to_string(budget) + "\n}\n");
  }
  json rows(const std::vector<std::string>& arguments) {
    const Outputs outputs = granary(arguments);
    EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
    return json::parse(outputs.out);
  }
  json study(const std::string& name) {
    for (const json& row : rows({"study", "ls", "--format", "json"}))
      if (row["study"] == name) return row;
    return {};
  }
  bool completes(const std::string& name) {
    return eventually([&] { return study(name)["state"] == "complete"; }, std::chrono::minutes(3));
  }
  // What must not depend on when something happened, or on which job answered.
  json timeless_history(const std::string& name) {
    json history = rows({"study", "history", name, "--format", "json"});
    for (json& trial : history)
      for (const char* key : {"study", "job", "cpu_s", "reused"}) trial.erase(key);
    return history;
  }
};

TEST_F(Optimize, spends_its_budget_and_reports_a_best_trial) {
  start_worker(2);
  const Outputs outputs =
      granary({"optimize", study_file("CMA_ES", 14), "--wait", "--format", "json"});
  ASSERT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_EQ(std::count(outputs.out.begin(), outputs.out.end(), '\n'), 14);
  const json summary = study("studies/1");
  EXPECT_EQ(summary["state"], "complete");
  EXPECT_GE(summary["best_objective"].get<double>(), 1.0) << "x0 itself scores 1";
  EXPECT_THAT(summary["verdict"].get<std::string>(), HasSubstr("best"));
  const json pareto =
      rows({"query", "SELECT number, f1_m, objective FROM pareto", "--format", "json"});
  ASSERT_EQ(pareto.size(), 1u) << "one criterion: the front is the best";
  EXPECT_EQ(pareto[0]["number"], summary["best_trial"]);
  EXPECT_EQ(rows({"study", "extend", "studies/1", "--budget", "18", "--format", "json"})["state"],
            "running");
  ASSERT_TRUE(completes("studies/1"));
  EXPECT_EQ(granary({"watch", "studies/1"}).exit_code, 0);
  EXPECT_EQ(study("studies/1")["ended_trials"], 18);
}

TEST_F(Optimize, twenty_kills_of_the_server_leave_the_history_of_an_undisturbed_run) {
  start_worker(2);
  const std::string file = study_file("GRADUAL_DEFORMATION", 40);
  const Outputs submitted = granary({"optimize", file});
  ASSERT_EQ(submitted.out, "studies/1\n") << submitted.err;
  std::mt19937 dice(20);
  for (int kill = 0; kill < 20; ++kill) {
    // Any moment will do; that the study is not over is what counts.
    std::this_thread::sleep_for(std::chrono::milliseconds(dice() % 150));
    kill_server();
    start_server();
  }
  ASSERT_TRUE(completes("studies/1"));
  const Outputs again = granary({"optimize", file});
  ASSERT_EQ(again.out, "studies/2\n") << again.err;
  ASSERT_TRUE(completes("studies/2"));
  EXPECT_EQ(timeless_history("studies/1"), timeless_history("studies/2"));
  EXPECT_EQ(study("studies/1")["verdict"], study("studies/2")["verdict"]);
  EXPECT_EQ(study("studies/2")["reused_trials"], 40) << "every scene was the same";
}

TEST_F(Optimize, the_history_is_exported_to_hdf5) {
  start_worker(2);
  ASSERT_EQ(granary({"optimize", study_file("RANDOM_SEARCH", 6), "--wait"}).exit_code, 0);
  const std::string file = scratch.file("history.h5");
  const Outputs exported = granary({"study", "history", "studies/1", "--hdf5", file});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const Outputs dump = run_program({.command = {"/usr/bin/h5dump", "-n", "1", file},
                                    .environment = {},
                                    .input = "",
                                    .on_terminal = false});
  ASSERT_EQ(dump.exit_code, 0) << dump.err;
  for (const char* part : {"/study/spec", "/trials/objective", "/inputs/discharge.bucket.x2_m",
                           "/values/f1_m", "/errors/f1_m", "/trials/job"})
    EXPECT_THAT(dump.out, HasSubstr(part));
}

TEST_F(Optimize, bad_study_files_are_refused_with_a_reason) {
  const auto refused = [&](const std::string& text) {
    const Outputs outputs = granary({"optimize", scratch.write("bad.txtpb", text)});
    EXPECT_EQ(outputs.exit_code, 2) << text;
    return outputs.err;
  };
  EXPECT_THAT(refused("optimise { }"), HasSubstr("optimize"));
  EXPECT_THAT(refused("scene_file: \"missing.txtpb\" optimize { budget: 3 }"),
              HasSubstr("missing.txtpb"));
  EXPECT_THAT(refused("scene_file: \"" + scene("discharge_small") + "\" optimize { budget: 3 }"),
              HasSubstr("vary"));
  EXPECT_THAT(refused("sweep { }"), HasSubstr("scene"));
  EXPECT_EQ(rows({"study", "ls", "--format", "json"}).size(), 0u);
}

TEST_F(Optimize, the_shipped_studies_are_accepted) {
  for (const char* name : {"wall_small", "wall_4000_weights", "wall_4000_paper", "wall_4000_front",
                           "deflector_gravity"}) {
    const Outputs outputs =
        granary({"optimize", std::string(GRANARY_SCENES) + "/studies/" + name + ".txtpb"});
    EXPECT_EQ(outputs.exit_code, 0) << name << ": " << outputs.err;
  }
}

}  // namespace
}  // namespace granary::test
