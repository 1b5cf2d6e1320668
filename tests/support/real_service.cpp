#include "tests/support/real_service.h"

#include <signal.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/support/slowdown.h"

namespace granary::test {

bool eventually(const std::function<bool()>& holds, std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + kSlowdown * patience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

namespace {

std::string file_start(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

pid_t parent_of(const std::filesystem::path& process) {
  const std::string status = file_start(process / "status");
  const auto at = status.find("PPid:");
  return at == std::string::npos ? -1 : static_cast<pid_t>(std::stol(status.substr(at + 5)));
}

}  // namespace

std::vector<pid_t> processes_with(const std::string& text) {
  std::vector<pid_t> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (file_start(entry.path() / "cmdline").find(text) != std::string::npos)
      found.push_back(static_cast<pid_t>(std::stol(name)));
  }
  return found;
}

std::vector<pid_t> children_with(pid_t parent, const std::string& text) {
  std::vector<pid_t> found = processes_with(text);
  std::erase_if(found,
                [&](pid_t pid) { return parent_of("/proc/" + std::to_string(pid)) != parent; });
  return found;
}

bool is_alive(pid_t pid) {
  return ::kill(pid, 0) == 0;
}

void RealService::start_server() {
  std::vector<std::string> command{GRANARY_BIN "/granaryd", "--data", scratch.file("data"), "--listen", address};
  command.insert(command.end(), server_arguments.begin(), server_arguments.end());
  server = std::make_unique<Program>(ProgramOptions{
      .command = command,
      .environment = server_environment,
      .input = "",
      .on_terminal = false});
  ASSERT_TRUE(server->prints("listening on")) << server->err();
}

void RealService::kill_server() {
  server->signal(SIGKILL);
  server->wait();
}

Program& RealService::start_worker(int slots, const std::map<std::string, std::string>& environment) {
  workers.push_back(std::make_unique<Program>(
      ProgramOptions{.command = {GRANARY_BIN "/granary-worker", "--server", address, "--slots",
                                 std::to_string(slots), "--work-dir", scratch.file("work")},
                     .environment = environment,
                     .input = "",
                     .on_terminal = false}));
  EXPECT_TRUE(workers.back()->prints("event=connected")) << workers.back()->err();
  return *workers.back();
}

Outputs RealService::granary(std::vector<std::string> arguments, const std::string& input) {
  arguments.insert(arguments.begin(), GRANARY_BIN "/granary");
  return run_program({.command = arguments,
                      .environment = {{"GRANARY_SERVER", address}, {"HOME", scratch.path()}},
                      .input = input,
                      .on_terminal = false});
}

std::unique_ptr<Program> RealService::start_granary(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), GRANARY_BIN "/granary");
  return std::make_unique<Program>(
      ProgramOptions{.command = arguments,
                     .environment = {{"GRANARY_SERVER", address}, {"HOME", scratch.path()}},
                     .input = "",
                     .on_terminal = false});
}

std::string RealService::scene(const std::string& name) const {
  return std::string(GRANARY_SCENES) + "/" + name + ".txtpb";
}

std::vector<std::string> RealService::submit(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "submit");
  const Outputs outputs = granary(arguments);
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  std::istringstream lines(outputs.out);
  std::vector<std::string> jobs;
  for (std::string line; std::getline(lines, line);) jobs.push_back(line);
  return jobs;
}

nlohmann::json RealService::status(const std::string& job) {
  const Outputs outputs = granary({"status", job, "--format", "json"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  return nlohmann::json::parse(outputs.out);
}

bool RealService::reaches(const std::string& job, const std::string& wanted,
                          std::chrono::milliseconds patience) {
  return eventually([&] { return state(job) == wanted; }, patience);
}

std::vector<std::string> RealService::long_scene() const {
  return {scene("discharge_small"), "--set", "discharge.time_step_s=1e-6", "--set",
          "discharge.filling_time_step_s=1e-6"};
}

}  // namespace granary::test
