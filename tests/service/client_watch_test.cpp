// watch: live and plain progress, broken streams, Ctrl-C, and the exit code of every end.
#include <signal.h>

#include <nlohmann/json.hpp>

#include "tests/support/client_fixture.h"

namespace granary::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using Json = nlohmann::json;

class ClientWatch : public ClientTest {};

TEST_F(ClientWatch, ends_with_100_percent_on_stderr_and_the_job_on_stdout) {
  jobs().add("jobs/7");
  const Outputs outputs = granary({"watch", "7"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_THAT(outputs.err, HasSubstr("jobs/7: [####################] 100 %  complete"));
  EXPECT_THAT(outputs.out, HasSubstr("jobs/7  discharge  complete  100 %"));
  EXPECT_THAT(outputs.err + outputs.out, Not(HasSubstr("\x1b")));
}

TEST_F(ClientWatch, resumes_a_cut_stream_behind_the_last_event_and_repeats_nothing) {
  FakeJob& job = jobs().add("jobs/7");
  job.cut_watch = {2, 0, 1};  // after the 2nd event; at once; after the 3rd
  const Outputs outputs = granary({"watch", "jobs/7", "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  std::vector<int> seen;
  std::istringstream lines(outputs.out);
  for (std::string line; std::getline(lines, line);) seen.push_back(Json::parse(line)["sequence"]);
  EXPECT_EQ(seen, (std::vector<int>{1, 2, 3, 4, 5}));
  std::vector<std::uint64_t> resumed;
  for (const auto& request : jobs().watches()) resumed.push_back(request.after_sequence());
  EXPECT_EQ(resumed, (std::vector<std::uint64_t>{0, 2, 2, 3}));
}

TEST_F(ClientWatch, survives_a_restart_of_the_server) {
  FakeJob& job = jobs().add("jobs/7", v1::RUNNING);
  job.hold_watch = true;
  Program watch(command({"watch", "jobs/7"}));
  ASSERT_TRUE(watch.prints("25 %")) << watch.err();
  job.hold_watch = false;
  job.events.push_back(state_event(5, v1::COMPLETE));
  job.job.set_state(v1::COMPLETE);
  server_.restart();
  EXPECT_EQ(watch.wait(), 0) << watch.err();
  EXPECT_GE(jobs().watches().back().after_sequence(), 3u);
}

TEST_F(ClientWatch, exit_code_tells_how_the_job_ended) {
  for (const auto& [state, code] : std::vector<std::pair<v1::JobState, int>>{
           {v1::ERROR, 1}, {v1::UNSTABLE, 6}, {v1::CANCELLED, 7}}) {
    FakeJob& job = jobs().add("jobs/7", state);
    job.job.set_error("reason for it");
    const Outputs outputs = granary({"watch", "jobs/7"});
    EXPECT_EQ(outputs.exit_code, code);
    EXPECT_THAT(outputs.err, HasSubstr("reason for it"));
  }
  jobs().add("jobs/8", v1::CANCELLED).job.set_timed_out(true);
  EXPECT_EQ(granary({"watch", "jobs/8"}).exit_code, 8);
}

TEST_F(ClientWatch, interrupt_detaches_says_how_to_resume_and_cancels_nothing) {
  jobs().add("jobs/7", v1::RUNNING).hold_watch = true;
  Program watch(command({"watch", "jobs/7"}));
  ASSERT_TRUE(watch.prints("jobs/7: running")) << watch.err();
  watch.signal(SIGINT);
  EXPECT_EQ(watch.wait(), 130);
  EXPECT_TRUE(watch.prints("granary watch jobs/7")) << watch.err();
  EXPECT_EQ(jobs().calls("Cancel"), 0);
}

TEST_F(ClientWatch, interrupt_of_run_detaches_too) {
  jobs().add("jobs/held", v1::RUNNING).hold_watch = true;
  // The fake's next job: complete, but its stream stays silent.
  Program run(command({"submit", scene(), "--wait", "--request-id", "x"}));
  EXPECT_EQ(run.wait(), 0);
  FakeJob& job = jobs()["jobs/new2"];
  job.events.resize(3);
  job.hold_watch = true;
  Program again(command({"run", scene(), "--request-id", "x"}));
  ASSERT_TRUE(again.prints("jobs/new2: running")) << again.err();
  again.signal(SIGINT);
  EXPECT_EQ(again.wait(), 130);
  EXPECT_TRUE(again.prints("granary watch jobs/new2")) << again.err();
  EXPECT_THAT(again.out(), IsEmpty());
}

TEST_F(ClientWatch, draws_a_live_bar_on_a_terminal_and_none_elsewhere) {
  FakeJob& job = jobs().add("jobs/7", v1::RUNNING);
  job.hold_watch = true;
  ProgramOptions options = command({"watch", "jobs/7"});
  options.on_terminal = true;
  Program live(options);
  EXPECT_TRUE(live.prints("[#####...............]  25 %  rotation")) << live.err();
}

TEST_F(ClientWatch, no_color_means_no_escape_sequences_on_a_terminal) {
  jobs().add("jobs/7");
  ProgramOptions options = command({"watch", "jobs/7"});
  options.on_terminal = true;
  options.environment["NO_COLOR"] = "1";
  const Outputs outputs = run_program(options);
  EXPECT_EQ(outputs.exit_code, 0);
  EXPECT_THAT(outputs.err, Not(HasSubstr("\x1b")));
  EXPECT_THAT(outputs.err, HasSubstr("100 %  complete"));
}

TEST_F(ClientWatch, unknown_job_ends_at_once_with_3) {
  const Outputs outputs = granary({"watch", "jobs/none"});
  EXPECT_EQ(outputs.exit_code, 3);
  EXPECT_THAT(outputs.err, IsOneErrorLine());
}

}  // namespace
}  // namespace granary::test
