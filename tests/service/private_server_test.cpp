// When no server is named, the private one of the data directory is started, shared, and leaves.
#include "tests/support/real_service.h"

namespace granary::test {
namespace {

class PrivateServer : public testing::Test {
 protected:
  ProgramOptions granary(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), GRANARY_BIN "/granary");
    return {.command = arguments,
            .environment = {{"GRANARY_DATA", scratch.file("data")},
                            {"HOME", scratch.path()},
                            {"GRANARY_PRIVATE_IDLE_S", "2"}},
            .input = "",
            .on_terminal = false};
  }
  // Looks from outside: a question to the server would keep it.
  bool has_left() const { return processes_with(scratch.file("data")).empty(); }

  ScratchDirectory scratch;
};

TEST_F(PrivateServer, two_runs_at_once_share_it_its_results_stay_and_it_leaves_by_itself) {
  const std::string scene = std::string(GRANARY_SCENES) + "/discharge_small.txtpb";
  Program first(granary({"run", scene, "--set", "seed=1", "--format", "json"}));
  Program second(granary({"run", scene, "--set", "seed=2", "--format", "json"}));
  EXPECT_EQ(first.wait(std::chrono::seconds(60)), 0) << first.err();
  EXPECT_EQ(second.wait(std::chrono::seconds(60)), 0) << second.err();
  const Outputs listed = run_program(granary({"ls", "--format", "json"}));
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_EQ(nlohmann::json::parse(listed.out).size(), 2u) << "one queue for both";
  EXPECT_TRUE(eventually([&] { return has_left(); }, std::chrono::seconds(30)));
  // Started again by the next verb; what was computed is still there.
  const Outputs later = run_program(granary({"ls", "--format", "json"}));
  EXPECT_EQ(nlohmann::json::parse(later.out).size(), 2u);
  EXPECT_TRUE(eventually([&] { return has_left(); }, std::chrono::seconds(30)));
}

}  // namespace
}  // namespace granary::test
