// The verbs that ask about and act on jobs: shapes in every format, exit codes.
#include <nlohmann/json.hpp>

#include "tests/support/client_fixture.h"

namespace granary::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using Json = nlohmann::json;

class ClientJobs : public ClientTest {
 protected:
  void add_values(const std::string& name, v1::JobState state = v1::COMPLETE) {
    FakeJob& fake = jobs().add(name, state);
    auto& values = *fake.values.mutable_result()->mutable_values();
    values["f1_m"].set_value(1.92);
    values["f1_m"].set_error(0.01);
    values["f1_m"].set_unit("m");
    values["f4_m"].set_error_basis("no disk left the bucket");
  }
};

TEST_F(ClientJobs, ls_json_is_an_array_of_objects) {
  jobs().add("jobs/1").job.set_priority(3);
  jobs().add("jobs/2", v1::RUNNING);
  const Outputs outputs = granary({"ls", "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  const Json list = Json::parse(outputs.out);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0]["job"], "jobs/1");
  EXPECT_EQ(list[0]["kind"], "discharge");
  EXPECT_EQ(list[0]["state"], "complete");
  EXPECT_EQ(list[0]["priority"], 3);
  EXPECT_TRUE(list[0]["worker"].is_null());
  EXPECT_EQ(Json::parse(granary({"ls", "--state", "running", "--format", "json"}).out).size(), 1u);
}

TEST_F(ClientJobs, ls_of_nothing_is_an_empty_array) {
  EXPECT_EQ(granary({"ls", "--format", "json"}).out, "[]\n");
}

TEST_F(ClientJobs, ls_follows_pages_to_its_limit) {
  for (int i = 0; i < 1203; ++i) jobs().add("jobs/" + std::to_string(10000 + i));
  const auto count = [&](const std::string& limit) {
    return Json::parse(granary({"ls", "--limit", limit, "--format", "json"}).out).size();
  };
  EXPECT_EQ(count("0"), 1203u);
  EXPECT_EQ(count("701"), 701u);
  EXPECT_THAT(granary({"ls"}).err, HasSubstr("--limit 0"));
}

TEST_F(ClientJobs, status_json_is_one_object_a_line) {
  jobs().add("jobs/1");
  jobs().add("jobs/2");
  const Outputs outputs = granary({"status", "1", "jobs/2", "--format", "json"});
  std::istringstream lines(outputs.out);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(Json::parse(line)["job"], "jobs/1");
  std::getline(lines, line);
  EXPECT_EQ(Json::parse(line)["job"], "jobs/2");
}

TEST_F(ClientJobs, one_missing_job_does_not_hide_the_others) {
  jobs().add("jobs/2");
  const Outputs outputs = granary({"status", "1", "2"});
  EXPECT_EQ(outputs.exit_code, 3);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
  EXPECT_THAT(outputs.out, HasSubstr("jobs/2"));
}

TEST_F(ClientJobs, job_names_come_from_stdin_too) {
  jobs().add("jobs/1");
  jobs().add("jobs/2");
  const Outputs outputs = granary({"cancel", "-"}, "jobs/1\njobs/2\n");
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_EQ(jobs().calls("Cancel"), 2);
  EXPECT_THAT(outputs.out, HasSubstr("cancelled"));
}

TEST_F(ClientJobs, values_json_is_the_contract_s_line) {
  add_values("jobs/1");
  const Outputs outputs = granary({"values", "jobs/1", "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  const Json line = Json::parse(outputs.out);
  EXPECT_EQ(line["values"]["f1_m"]["value"], 1.92);
  EXPECT_EQ(line["values"]["f1_m"]["error"], 0.01);
  EXPECT_TRUE(line["values"]["f4_m"]["value"].is_null());
}

TEST_F(ClientJobs, values_csv_has_a_row_per_observable) {
  add_values("jobs/1");
  EXPECT_EQ(granary({"values", "jobs/1", "--format", "csv"}).out,
            "job,observable,value,error,unit,error_basis\n"
            "jobs/1,f1_m,1.92,0.01,m,\n"
            "jobs/1,f4_m,,,,no disk left the bucket\n");
}

TEST_F(ClientJobs, values_exit_code_tells_how_the_job_ended) {
  for (const auto& [state, code] : std::vector<std::pair<v1::JobState, int>>{
           {v1::ERROR, 1}, {v1::UNSTABLE, 6}, {v1::CANCELLED, 7}, {v1::RUNNING, 2}}) {
    add_values("jobs/1", state);
    const Outputs outputs = granary({"values", "jobs/1", "--format", "json"});
    EXPECT_EQ(outputs.exit_code, code);
    EXPECT_THAT(outputs.err, IsOneErrorLine());
  }
  EXPECT_EQ(granary({"values", "jobs/none"}).exit_code, 3);
}

TEST_F(ClientJobs, explain_lists_decisions_with_who_and_why) {
  FakeJob& fake = jobs().add("jobs/1");
  EXPECT_EQ(granary({"explain", "1"}).exit_code, 2);
  auto* decision = fake.values.mutable_result()->add_decisions();
  decision->set_path("discharge.time_step_s");
  decision->set_value("0.0002");
  decision->set_chosen_by("auto");
  decision->set_evidence("default ladder rung");
  const Json list = Json::parse(granary({"explain", "1", "--format", "json"}).out);
  EXPECT_EQ(list[0]["path"], "discharge.time_step_s");
  EXPECT_EQ(list[0]["chosen_by"], "auto");
}

TEST_F(ClientJobs, logs_cannot_control_the_terminal) {
  jobs().add("jobs/1").logs = {"step 1",
                               "\x1b]0;evil\x07"
                               "step 2"};
  EXPECT_EQ(granary({"logs", "1"}).out, "step 1\n ]0;evil step 2\n");
}

TEST_F(ClientJobs, workers_are_listed) {
  const Json list = Json::parse(granary({"workers", "--format", "json"}).out);
  EXPECT_EQ(list[0]["worker"], "w1");
  EXPECT_EQ(list[0]["tasks"], Json::array({"tasks/7"}));
}

TEST_F(ClientJobs, foreign_job_names_are_refused_here) {
  for (const char* name : {"studies/1", "../../etc/passwd", ""}) {
    EXPECT_EQ(granary({"status", name}).exit_code, 2) << name;
  }
  EXPECT_EQ(jobs().calls("Get"), 0);
}

}  // namespace
}  // namespace granary::test
