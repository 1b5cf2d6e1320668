#include "client/session/private_server.h"

#include <sys/wait.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "client/session/child_process.h"
#include "client/session/data_directory.h"
#include "client/session/file_lock.h"

namespace granary::session {
namespace {

using Clock = std::chrono::steady_clock;

// Opening a large database after a crash takes longest.
constexpr std::chrono::seconds kStartTimeout{30};
constexpr std::chrono::milliseconds kPollInterval{20};
constexpr std::chrono::milliseconds kProbeTimeout{500};

std::string last_line_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) last = line;
  return last.substr(0, 400);
}

Error start_failure(const DataDirectory& directory, const std::string& what) {
  const std::string cause = last_line_of(directory.private_log());
  return {ErrorCode::unavailable,
          "the private server of " + directory.path().string() + " " + what +
              (cause.empty() ? "" : ": " + cause) + " (log: " + directory.private_log().string() +
              ")",
          ""};
}

Result<pid_t> start_supervisor(const DataDirectory& directory, const Settings& settings) {
  return start_child(
      {.command = {program_directory() / "granary", "up", "--private", "--data", directory.path(),
                   "--log-level", settings[SettingKey::log_level].value},
       .log_file = directory.private_log(),
       .detached = true});
}

Result<std::shared_ptr<Connection>> wait_until_serving(const DataDirectory& directory,
                                                       pid_t supervisor) {
  const auto deadline = Clock::now() + kStartTimeout;
  while (Clock::now() < deadline) {
    if (auto connection = serving_connection(directory.server_address(), kProbeTimeout))
      return connection;
    if (waitpid(supervisor, nullptr, WNOHANG) == supervisor)
      return start_failure(directory, "stopped while starting");
    std::this_thread::sleep_for(kPollInterval);
  }
  return start_failure(directory, "did not come up in time");
}

}  // namespace

std::shared_ptr<Connection> serving_connection(const std::string& address,
                                               std::chrono::milliseconds timeout) {
  const auto connection = Connection::open({address, "", ""}, timeout);
  return connection && (*connection)->check_health(timeout) ? *connection : nullptr;
}

Result<std::shared_ptr<Connection>> join_private_server(
    const Settings& settings, const std::function<void(std::string_view)>& notice) {
  auto directory = DataDirectory::open(settings[SettingKey::data].value);
  if (!directory) return directory.error();
  if (auto socket = directory->socket_address(); !socket) return socket.error();
  const auto lock = FileLock::wait(directory->start_lock());
  if (!lock) return lock.error();
  if (auto running = serving_connection(directory->server_address(), kConnectTimeout))
    return running;
  notice("starting the private server of " + directory->path().string());
  const auto supervisor = start_supervisor(*directory, settings);
  if (!supervisor) return supervisor.error();
  return wait_until_serving(*directory, *supervisor);
}

}  // namespace granary::session
