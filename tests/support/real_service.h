// A real granaryd on a Unix socket of its own with real granary-worker processes, and the real
// client to talk to them. Everything is killed and removed at the end.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace granary::test {

// Polls until `holds` or the deadline; returns whether it held.
bool eventually(const std::function<bool()>& holds,
                std::chrono::milliseconds patience = std::chrono::seconds(20));

// Processes whose command line contains `text`; of one parent, or of any.
std::vector<pid_t> children_with(pid_t parent, const std::string& text);
std::vector<pid_t> processes_with(const std::string& text);
bool is_alive(pid_t pid);

class RealService : public testing::Test {
 protected:
  void SetUp() override { start_server(); }

  void start_server();
  void kill_server();
  Program& start_worker(int slots = 1, const std::map<std::string, std::string>& environment = {});

  // The client against this server.
  Outputs granary(std::vector<std::string> arguments, const std::string& input = "");
  std::unique_ptr<Program> start_granary(std::vector<std::string> arguments);

  std::string scene(const std::string& name) const;  // path of a shipped scene
  // Submits; expects success; returns the job names.
  std::vector<std::string> submit(std::vector<std::string> arguments);
  nlohmann::json status(const std::string& job);
  std::string state(const std::string& job) { return status(job)["state"]; }
  bool reaches(const std::string& job, const std::string& state,
               std::chrono::milliseconds patience = std::chrono::seconds(60));

  // A discharge that computes for about half a minute, with the first progress after milliseconds.
  std::vector<std::string> long_scene() const;

  // Of the next start_server().
  std::map<std::string, std::string> server_environment;
  std::vector<std::string> server_arguments;

  ScratchDirectory scratch;
  std::string address = "unix:" + scratch.file("granaryd.sock");
  std::unique_ptr<Program> server;
  std::vector<std::unique_ptr<Program>> workers;
};

}  // namespace granary::test
