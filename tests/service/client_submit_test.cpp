// submit and run: what goes to the server, what comes out on which stream, and the exit code.
#include <nlohmann/json.hpp>

#include "tests/support/client_fixture.h"

namespace granary::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Json = nlohmann::json;

class ClientSubmit : public ClientTest {};

TEST_F(ClientSubmit, prints_job_names_alone_one_a_line) {
  const Outputs outputs = granary({"submit", scene(), scene()});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_EQ(outputs.out, "jobs/new1\njobs/new2\n");
  EXPECT_THAT(outputs.err, IsEmpty());
}

TEST_F(ClientSubmit, sends_many_scenes_in_one_batch_with_all_options) {
  const Outputs outputs =
      granary({"submit", scene(), scene(), "--set", "discharge.rotation_rad_per_s=7.5", "--set",
               "seed=9", "--tag", "study=walls", "--tag", "who=me=you", "--priority", "-3",
               "--request-id", "once", "--fresh", "--time-limit", "10m"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  ASSERT_EQ(jobs().submissions().size(), 1u);
  const v1::SubmitJobsRequest request = jobs().submissions()[0];
  EXPECT_EQ(request.request_id(), "once");
  ASSERT_EQ(request.items_size(), 2);
  const auto& item = request.items(1);
  EXPECT_EQ(item.scene().discharge().rotation_rad_per_s(), 7.5);
  EXPECT_EQ(item.scene().seed(), 9u);
  EXPECT_EQ(item.tags().at("study"), "walls");
  EXPECT_EQ(item.tags().at("who"), "me=you");
  EXPECT_EQ(item.priority(), -3);
  EXPECT_EQ(item.time_limit_s(), 600);
  EXPECT_TRUE(item.fresh());
}

TEST_F(ClientSubmit, sends_the_scene_as_written_and_leaves_defaults_to_the_server) {
  EXPECT_EQ(granary({"submit", scene()}).exit_code, 0);
  const v1::Scene sent = jobs().submissions()[0].items(0).scene();
  EXPECT_FALSE(sent.discharge().has_time_step_s());
  EXPECT_FALSE(sent.has_threads());
}

TEST_F(ClientSubmit, threads_setting_fills_scenes_that_do_not_say) {
  const std::string silent = scene();
  const std::string says = scratch_.write("says.txtpb", std::string(kSmallScene) + "threads: 3\n");
  EXPECT_EQ(granary({"submit", silent, says, "--threads", "2"}).exit_code, 0);
  EXPECT_EQ(jobs().submissions()[0].items(0).scene().threads(), 2u);
  EXPECT_EQ(jobs().submissions()[0].items(1).scene().threads(), 3u);
}

TEST_F(ClientSubmit, lost_reply_is_repeated_with_the_same_request_id) {
  jobs().lose_replies("Submit", 2);
  const Outputs outputs = granary({"submit", scene()});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_EQ(outputs.out, "jobs/new1\n");
  const auto submissions = jobs().submissions();
  ASSERT_EQ(submissions.size(), 3u);
  EXPECT_FALSE(submissions[0].request_id().empty());
  EXPECT_EQ(submissions[0].request_id(), submissions[2].request_id());
}

TEST_F(ClientSubmit, two_submissions_never_share_a_generated_request_id) {
  EXPECT_EQ(granary({"submit", scene()}).out, "jobs/new1\n");
  EXPECT_EQ(granary({"submit", scene()}).out, "jobs/new2\n");
}

TEST_F(ClientSubmit, wait_with_json_prints_one_line_of_values_per_job) {
  const Outputs outputs = granary({"submit", scene(), scene(), "--wait", "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  std::istringstream lines(outputs.out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count)
    EXPECT_EQ(Json::parse(line)["job"], "jobs/new" + std::to_string(count + 1));
  EXPECT_EQ(count, 2);
}

TEST_F(ClientSubmit, wait_without_json_still_prints_names_alone) {
  const Outputs outputs = granary({"submit", scene(), "--wait"});
  EXPECT_EQ(outputs.out, "jobs/new1\n");
  EXPECT_THAT(outputs.err, HasSubstr("100 %  complete"));
}

TEST_F(ClientSubmit, refusal_of_the_server_is_one_line_and_its_code) {
  jobs().fail("Submit", ErrorCode::resource_exhausted, "the queue is full");
  const Outputs outputs = granary({"submit", scene()});
  EXPECT_EQ(outputs.exit_code, 1);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
  EXPECT_THAT(outputs.err, HasSubstr("the queue is full"));
  EXPECT_THAT(outputs.out, IsEmpty());
}

class ClientRun : public ClientTest {};

TEST_F(ClientRun, shows_progress_on_stderr_and_values_alone_on_stdout) {
  const Outputs outputs = granary({"run", scene(), "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  const Json line = Json::parse(outputs.out);
  EXPECT_EQ(line["job"], "jobs/new1");
  EXPECT_EQ(line["state"], "complete");
  EXPECT_EQ(std::count(outputs.out.begin(), outputs.out.end(), '\n'), 1);
  EXPECT_THAT(outputs.err, HasSubstr("jobs/new1: running"));
  EXPECT_THAT(outputs.err, HasSubstr("100 %  complete"));
}

TEST_F(ClientRun, quiet_leaves_stderr_empty) {
  const Outputs outputs = granary({"run", scene(), "-q", "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0);
  EXPECT_THAT(outputs.err, IsEmpty());
}

TEST_F(ClientRun, writes_data_to_the_file_of_o) {
  const Outputs outputs =
      granary({"run", scene(), "--format", "json", "-o", scratch_.file("values.json")});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_THAT(outputs.out, IsEmpty());
  EXPECT_EQ(Json::parse(file_text(scratch_.file("values.json")))["job"], "jobs/new1");
}

TEST_F(ClientRun, takes_one_scene) {
  EXPECT_EQ(granary({"run", scene(), scene()}).exit_code, 2);
}

}  // namespace
}  // namespace granary::test
