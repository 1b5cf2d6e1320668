#include "worker/agent/engine_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <utility>

extern char** environ;

namespace granary::agent {
namespace {

constexpr std::uint32_t kMaxProgressBytes = 1 << 20;

// posix_spawn's attribute and action objects with their destructors.
struct SpawnSetup {
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_t actions;

  SpawnSetup() {
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes, 0);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
  }
  ~SpawnSetup() {
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
  }
};

bool read_exactly(int descriptor, void* buffer, std::size_t bytes) {
  auto* at = static_cast<char*>(buffer);
  while (bytes > 0) {
    const ssize_t got = ::read(descriptor, at, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace

Result<EngineProcess> EngineProcess::start(const std::filesystem::path& program,
                                           const std::filesystem::path& folder) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return Error{ErrorCode::internal, std::string("cannot make a pipe: ") + std::strerror(errno),
                 ""};
  SpawnSetup setup;
  const std::string log = (folder / "engine.log").string();
  posix_spawn_file_actions_adddup2(&setup.actions, ends[1], 1);
  posix_spawn_file_actions_addopen(&setup.actions, 2, log.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                   0600);
  posix_spawn_file_actions_addopen(&setup.actions, 0, "/dev/null", O_RDONLY, 0);
  std::string name = program.string(), engine = "--engine", argument = folder.string();
  std::string parent = "--parent", parent_id = std::to_string(::getpid());
  char* arguments[] = {name.data(),   engine.data(),    argument.data(),
                       parent.data(), parent_id.data(), nullptr};
  pid_t pid = -1;
  const int error =
      ::posix_spawn(&pid, name.c_str(), &setup.actions, &setup.attributes, arguments, environ);
  ::close(ends[1]);
  if (error != 0) {
    ::close(ends[0]);
    return Error{ErrorCode::internal, "cannot start " + name + ": " + std::strerror(error), ""};
  }
  return EngineProcess(pid, ends[0]);
}

EngineProcess::EngineProcess(EngineProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), pipe_(std::exchange(other.pipe_, -1)) {}

EngineProcess::~EngineProcess() {
  if (pid_ > 0) {
    signal_group(pid_, SIGKILL);
    wait();
  }
  if (pipe_ >= 0) ::close(pipe_);
}

void EngineProcess::signal_group(pid_t group, int signal) {
  if (group > 0) ::kill(-group, signal);
}

void EngineProcess::read_progress(const std::function<void(const v1::Progress&)>& deliver) {
  for (;;) {
    std::uint32_t length = 0;
    if (!read_exactly(pipe_, &length, sizeof length) || length > kMaxProgressBytes) return;
    std::string bytes(length, '\0');
    if (!read_exactly(pipe_, bytes.data(), length)) return;
    v1::Progress progress;
    if (progress.ParseFromString(bytes)) deliver(progress);
  }
}

EngineExit EngineProcess::wait() {
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  if (WIFEXITED(status)) return {true, WEXITSTATUS(status)};
  return {false, WTERMSIG(status)};
}

}  // namespace granary::agent
