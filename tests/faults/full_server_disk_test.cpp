// A full disk under the server, at a commit and during an upload: nothing accepted is lost, intake says
// why it stops, and everything goes on by itself once there is room.
#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class FullServerDisk : public RealService {
 protected:
  void SetUp() override {
    server_environment = {{"LD_PRELOAD", FULL_DISK_SHIM},
                          // The sanitizer's build may be preloaded into as well.
                          {"ASAN_OPTIONS", "verify_asan_link_order=0"},
                          {"GRANARY_TEST_FULL_ROOT", scratch.file("data")},
                          {"GRANARY_TEST_FULL_FLAG", flag_}};
    RealService::SetUp();
  }
  void fill_disk() const { std::ofstream(flag_) << "full"; }
  void make_room() const { ::unlink(flag_.c_str()); }

  std::string flag_ = scratch.file("disk-is-full");
};

TEST_F(FullServerDisk, refuses_a_submission_with_a_clear_line_and_queues_nothing) {
  const std::string before = submit({scene("discharge_small")}).at(0);
  fill_disk();
  const Outputs refused = granary({"submit", scene("discharge_700_gravity")});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_EQ(refused.out, "");
  EXPECT_THAT(refused.err, HasSubstr("full"));
  make_room();
  EXPECT_EQ(state(before), "waiting") << "the queue is intact";
  EXPECT_EQ(submit({scene("discharge_small")}).size(), 1u) << "intake goes on by itself";
  EXPECT_EQ(json::parse(granary({"ls", "--format", "json"}).out).size(), 2u) << "the refused one left nothing";
}

TEST_F(FullServerDisk, during_the_commit_of_a_result_loses_no_result) {
  start_worker();
  const std::string job = submit({scene("discharge_small")}).at(0);
  ASSERT_TRUE(eventually([&] { return state(job) == "running" || state(job) == "complete"; }));
  fill_disk();
  // Neither the upload nor the result gets through; the worker keeps them.
  ASSERT_TRUE(eventually([&] {
    const std::string log = workers.back()->err() + server->err();
    return log.find("upload_failed") != std::string::npos || log.find("commit_failed") != std::string::npos;
  })) << workers.back()->err();
  EXPECT_EQ(state(job), "running");
  make_room();
  ASSERT_TRUE(reaches(job, "complete"));
  EXPECT_EQ(status(job)["attempts"], 1) << "it was computed once";
  EXPECT_EQ(granary({"fetch", job, "-o", scratch.file("result.h5")}).exit_code, 0);
  EXPECT_EQ(granary({"verify", scratch.file("result.h5")}).exit_code, 0);
}

TEST_F(FullServerDisk, a_server_that_keeps_room_free_says_so) {
  kill_server();
  server_arguments = {"--keep-free-mb", "1000000000"};
  start_server();
  ASSERT_TRUE(server->err().find("event=intake accepting=false") != std::string::npos ||
              server->prints("event=intake accepting=false"));
  const Outputs refused = granary({"submit", scene("discharge_small")});
  EXPECT_THAT(refused.err, HasSubstr("keeps 1000000000 MB for running jobs"));
  EXPECT_EQ(granary({"ls", "--format", "json"}).out, "[]\n");
}

}  // namespace
}  // namespace granary::test
