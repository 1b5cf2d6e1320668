#include "tests/support/engine_child.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace granary::testing {
namespace {

bool read_exactly(int descriptor, void* buffer, std::size_t byte_count) {
  auto* at = static_cast<char*>(buffer);
  while (byte_count > 0) {
    const ssize_t got = ::read(descriptor, at, byte_count);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    byte_count -= static_cast<std::size_t>(got);
  }
  return true;
}

std::filesystem::path log_path(const std::filesystem::path& directory) {
  return directory / "engine.log";
}

[[noreturn]] void become_engine(const std::string& program, const std::filesystem::path& directory,
                                int out) {
  dup2(out, STDOUT_FILENO);
  const int log = open(log_path(directory).c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  dup2(log, STDERR_FILENO);
  const std::string parent = std::to_string(getppid());
  execl(program.c_str(), program.c_str(), directory.c_str(), parent.c_str(), nullptr);
  _exit(127);
}

}  // namespace

EngineChild::EngineChild(const std::string& program, const std::filesystem::path& directory)
    : directory_(directory) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  pid_ = fork();
  if (pid_ == 0) become_engine(program, directory, ends[1]);
  close(ends[1]);
  pipe_ = ends[0];
}

EngineChild::~EngineChild() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    wait();
  }
  close_pipe();
}

std::optional<v1::Progress> EngineChild::read_progress() {
  std::uint32_t length = 0;
  if (!read_exactly(pipe_, &length, sizeof length)) return std::nullopt;
  std::string bytes(length, '\0');
  v1::Progress progress;
  if (!read_exactly(pipe_, bytes.data(), length) || !progress.ParseFromString(bytes))
    throw std::runtime_error("torn progress message");
  return progress;
}

std::vector<v1::Progress> EngineChild::read_all_progress() {
  std::vector<v1::Progress> events;
  while (auto progress = read_progress()) events.push_back(*progress);
  return events;
}

void EngineChild::close_pipe() {
  if (pipe_ >= 0) close(pipe_);
  pipe_ = -1;
}

void EngineChild::signal(int number) {
  kill(pid_, number);
}

int EngineChild::wait() {
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string EngineChild::log() const {
  std::ifstream in(log_path(directory_));
  return {std::istreambuf_iterator<char>(in), {}};
}

pid_t spawn_through_dying_parent(const std::string& program,
                                 const std::filesystem::path& directory) {
  int tell[2];
  if (pipe2(tell, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const pid_t parent = fork();
  if (parent == 0) {
    int progress[2];
    if (pipe2(progress, O_CLOEXEC) != 0) _exit(1);
    const pid_t engine = fork();
    if (engine == 0) become_engine(program, directory, progress[1]);
    char byte;
    while (read(progress[0], &byte, 1) < 0 && errno == EINTR) {
    }
    if (write(tell[1], &engine, sizeof engine) != sizeof engine) _exit(1);
    _exit(0);
  }
  close(tell[1]);
  pid_t engine = -1;
  if (!read_exactly(tell[0], &engine, sizeof engine)) throw std::runtime_error("no engine");
  close(tell[0]);
  waitpid(parent, nullptr, 0);
  return engine;
}

bool is_gone_within(pid_t pid, std::chrono::seconds deadline) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (std::chrono::steady_clock::now() < end) {
    if (kill(pid, 0) != 0 && errno == ESRCH) return true;
    // Where nobody reaps orphans a dead one stays as a zombie.
    std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
    std::string number, name, state;
    if (in >> number >> name >> state && state == "Z") return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace granary::testing
