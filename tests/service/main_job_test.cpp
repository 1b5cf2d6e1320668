// The main job: a discharge submitted over gRPC, run by a worker process, its values and result
// file fetched by the client.
#include <gmock/gmock.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;

class MainJob : public RealService {};

TEST_F(MainJob, gives_the_json_of_the_contract) {
  start_worker();
  const Outputs outputs = granary({"run", scene("discharge_small"), "--format", "json"});
  ASSERT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_EQ(std::count(outputs.out.begin(), outputs.out.end(), '\n'), 1);
  const json line = json::parse(outputs.out);
  EXPECT_EQ(line["job"], "jobs/1");
  EXPECT_EQ(line["kind"], "discharge");
  EXPECT_EQ(line["state"], "complete");
  for (const char* key : {"f1_m", "f2_m", "f3_percent", "f4_m", "f1_landing_m"}) {
    ASSERT_TRUE(line["values"].contains(key)) << key;
    EXPECT_TRUE(line["values"][key].contains("value")) << key;
    EXPECT_TRUE(line["values"][key].contains("error")) << key;
  }
  for (const char* key : {"wall_s", "cpu_s", "steps", "particle_steps", "ns_per_particle_step",
                          "contacts_per_particle", "threads", "peak_rss_bytes"})
    EXPECT_GT(line["cost"][key].get<double>(), 0) << key;
  EXPECT_LT(line["ledger"]["remainder_ratio"].get<double>(), 1e-3);
  for (const char* key : {"gas", "rotating_frame", "rolling_friction", "particle_rotation",
                          "tangential_history", "cohesion"})
    for (const char* part : {"on", "number", "threshold", "omitted_error"})
      EXPECT_TRUE(line["effects"][key].contains(part)) << key << "." << part;
  EXPECT_FALSE(line["engine_version"].get<std::string>().empty());
  EXPECT_EQ(line["state_hash"].get<std::string>().size(), 32u);
}

TEST_F(MainJob, the_result_file_arrives_whole_and_says_how_it_was_made) {
  start_worker();
  const std::string job = submit({scene("discharge_small"), "--wait"}).at(0);
  const std::string file = scratch.file("result.h5");
  ASSERT_EQ(granary({"fetch", job, "-o", file}).exit_code, 0);
  const Outputs verified =
      run_program({.command = {GRANARY_BIN "/granary-worker", "--verify", file},
                   .environment = {},
                   .input = "",
                   .on_terminal = false});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  const Outputs dump = run_program({.command = {"/usr/bin/h5dump", "-n", "1", file},
                                    .environment = {},
                                    .input = "",
                                    .on_terminal = false});
  ASSERT_EQ(dump.exit_code, 0) << dump.err;
  for (const char* part : {"/scene", "/values", "/series/remaining", "/series/cg", "/frames",
                           "/ledger", "/provenance"})
    EXPECT_THAT(dump.out, testing::HasSubstr(part));
}

TEST_F(MainJob, two_fresh_runs_are_bitwise_the_same) {
  start_worker(2);
  std::vector<std::string> hashes;
  for (int i = 0; i < 2; ++i) {
    const Outputs outputs =
        granary({"run", scene("discharge_small"), "--fresh", "--format", "json"});
    ASSERT_EQ(outputs.exit_code, 0) << outputs.err;
    const json line = json::parse(outputs.out);
    hashes.push_back(line["state_hash"].get<std::string>() + line["values"].dump());
    EXPECT_GT(line["cost"]["cpu_s"].get<double>(), 0);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST_F(MainJob, warnings_of_the_result_reach_whoever_reads_the_table) {
  start_worker();
  const Outputs run = granary({"run", scene("discharge_small")});  // 47 deg without rolling friction
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("warning: jobs/1: friction_pp_deg > 30"), std::string::npos) << run.err;
}

TEST_F(MainJob, a_second_request_is_answered_with_the_stored_result) {
  Program& worker = start_worker();
  const Outputs first = granary({"run", scene("discharge_small"), "--format", "json"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  worker.signal(SIGKILL);  // nobody can compute any more
  worker.wait();
  const Outputs second =
      granary({"run", scene("discharge_small"), "--set", "threads=2", "--format", "json"});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(json::parse(first.out)["state_hash"], json::parse(second.out)["state_hash"]);
  EXPECT_EQ(json::parse(second.out)["job"], "jobs/2");
}

}  // namespace
}  // namespace granary::test
