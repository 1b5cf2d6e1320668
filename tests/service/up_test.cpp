// granary up: one server and its workers as one thing.
#include <signal.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

class Up : public testing::Test {
 protected:
  ProgramOptions granary(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), GRANARY_BIN "/granary");
    return {.command = std::move(arguments),
            .environment = {{"GRANARY_DATA", data},
                            {"HOME", scratch.path()},
                            {"GRANARY_PRIVATE_IDLE_S", "1"}},
            .input = ""};
  }
  nlohmann::json workers() const {
    const Outputs outputs = run_program(granary({"workers", "--format", "json"}));
    return outputs.exit_code == 0 ? nlohmann::json::parse(outputs.out) : nlohmann::json::array();
  }
  std::size_t connected() const {
    std::size_t count = 0;
    for (const auto& worker : workers()) count += worker["state"] == "connected" ? 1 : 0;
    return count;
  }

  ScratchDirectory scratch;
  std::string data = scratch.file("data");
  std::string address = "unix:" + scratch.file("data/granaryd.sock");
};

TEST_F(Up, prints_its_address_alone_on_stdout_and_serves_verbs_of_the_same_data_directory) {
  Program up(granary({"up", "--workers", "2"}));
  ASSERT_TRUE(up.prints("Ctrl-C drains")) << up.err();
  EXPECT_TRUE(eventually([&] { return connected() == 2; })) << up.err();
  up.signal(SIGTERM);
  EXPECT_EQ(up.wait(), 0) << up.err();
  up.collect_output();
  EXPECT_EQ(up.out(), address + "\n");
}

TEST_F(Up, starts_a_killed_worker_again) {
  Program up(granary({"up", "--workers", "1"}));
  ASSERT_TRUE(up.prints("Ctrl-C drains")) << up.err();  // asked earlier, a private one would start
  ASSERT_TRUE(eventually([&] { return connected() == 1; })) << up.err();
  const auto first = children_with(up.pid(), "granary-worker");
  ASSERT_EQ(first.size(), 1u);
  kill(first[0], SIGKILL);
  EXPECT_TRUE(eventually([&] {
    const auto now = children_with(up.pid(), "granary-worker");
    return now.size() == 1 && now[0] != first[0];
  }));
  EXPECT_TRUE(up.prints("worker 1 was ended by a signal: Killed; starting it again")) << up.err();
}

TEST_F(Up, starts_a_killed_server_again_with_its_queue) {
  Program up(granary({"up", "--workers", "1"}));
  ASSERT_TRUE(up.prints("Ctrl-C drains")) << up.err();
  const std::string scene = std::string(GRANARY_SCENES) + "/discharge_small.txtpb";
  ASSERT_EQ(run_program(granary({"run", scene, "-q"})).exit_code, 0);
  const auto server = children_with(up.pid(), "--listen");
  ASSERT_EQ(server.size(), 1u);
  kill(server[0], SIGKILL);
  // The client may meet the dead socket first; the next server holds the same jobs.
  EXPECT_TRUE(eventually([&] {
    return run_program(granary({"values", "jobs/1", "--server", address})).exit_code == 0;
  })) << up.err();
}

TEST_F(Up, leaves_an_address_alone_that_another_server_serves) {
  Program up(granary({"up", "--workers", "1"}));
  ASSERT_TRUE(up.prints("Ctrl-C drains")) << up.err();
  const Outputs second = run_program(
      granary({"up", "--workers", "1", "--listen", address, "--data", scratch.file("other")}));
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_NE(second.err.find("another server serves " + address), std::string::npos) << second.err;
  EXPECT_TRUE(eventually([&] { return connected() == 1; })) << "of its own, and no other";
}

TEST_F(Up, interrupt_stops_workers_and_server_and_leaves_no_process) {
  Program up(granary({"up", "--workers", "2"}));
  ASSERT_TRUE(up.prints("Ctrl-C drains")) << up.err();
  ASSERT_TRUE(eventually([&] { return connected() == 2; })) << up.err();
  auto children = children_with(up.pid(), "granary-worker");
  for (pid_t pid : children_with(up.pid(), "--listen")) children.push_back(pid);
  ASSERT_EQ(children.size(), 3u);
  up.signal(SIGINT);
  EXPECT_EQ(up.wait(), 0) << up.err();
  for (pid_t pid : children) EXPECT_FALSE(is_alive(pid));
  EXPECT_EQ(run_program(granary({"health", "--server", address})).exit_code, 4);
}

TEST_F(Up, children_do_not_outlive_a_killed_supervisor) {
  Program up(granary({"up", "--workers", "1"}));
  ASSERT_TRUE(up.prints("Ctrl-C drains")) << up.err();  // asked earlier, a private one would start
  ASSERT_TRUE(eventually([&] { return connected() == 1; })) << up.err();
  auto children = children_with(up.pid(), "granary-worker");
  for (pid_t pid : children_with(up.pid(), "--listen")) children.push_back(pid);
  ASSERT_EQ(children.size(), 2u);
  up.signal(SIGKILL);
  EXPECT_TRUE(eventually([&] {
    return std::none_of(children.begin(), children.end(), [](pid_t pid) { return is_alive(pid); });
  }));
}

TEST_F(Up, second_one_on_the_same_data_is_refused_and_names_the_first) {
  Program up(granary({"up", "--workers", "1"}));
  ASSERT_TRUE(up.prints("Ctrl-C drains")) << up.err();
  const Outputs second = run_program(granary({"up"}));
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_NE(second.err.find("in use by another granary up (server " + address + ")"),
            std::string::npos)
      << second.err;
}

TEST_F(Up, server_that_cannot_start_ends_it_at_once) {
  const Outputs outputs = run_program(granary({"up", "--listen", "192.0.2.1:7443"}));
  EXPECT_EQ(outputs.exit_code, 2) << outputs.err;
}

TEST_F(Up, long_data_directory_gets_a_short_socket) {
  data = scratch.file(std::string(150, 'd'));
  const Outputs health = run_program(granary({"health", "--format", "json"}));
  EXPECT_EQ(health.exit_code, 0) << health.err;
  const auto line = nlohmann::json::parse(health.out);
  EXPECT_EQ(line["server"].get<std::string>().rfind("unix:/tmp/granary-", 0), 0u);
}

}  // namespace
}  // namespace granary::test
