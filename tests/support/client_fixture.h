// The real `granary` against a fake server: what every test of the client needs.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "tests/support/fake_jobs_service.h"
#include "tests/support/program.h"

namespace granary::test {

inline constexpr const char* kSmallScene = R"(discharge {
  particles { count: 20 diameter_min_m: 0.01 density_kg_per_m3: 2200 }
  friction_pp_deg: 30
  friction_pw_deg: 20
  rotation_rad_per_s: 10.5
}
)";

class ClientTest : public ::testing::Test {
 protected:
  ClientTest() : server_(scratch_.path()) {
    environment_ = {{"HOME", scratch_.path()}, {"GRANARY_SERVER", server_.address()}};
  }

  ProgramOptions command(std::vector<std::string> arguments, const std::string& input = "") {
    arguments.insert(arguments.begin(), GRANARY_BIN "/granary");
    return {.command = std::move(arguments), .environment = environment_, .input = input};
  }
  Outputs granary(std::vector<std::string> arguments, const std::string& input = "") {
    return run_program(command(std::move(arguments), input));
  }
  std::string scene() { return scratch_.write("scene.txtpb", kSmallScene); }
  FakeJobs& jobs() { return server_.jobs(); }

  ScratchDirectory scratch_;
  FakeServer server_;
  std::map<std::string, std::string> environment_;
};

// "granary: ..." and nothing else: what every failure must look like.
MATCHER(IsOneErrorLine, "is one line that starts with 'granary: '") {
  return arg.rfind("granary: ", 0) == 0 && std::count(arg.begin(), arg.end(), '\n') == 1 &&
         arg.back() == '\n' && arg.find('\x1b') == std::string::npos;
}

}  // namespace granary::test
