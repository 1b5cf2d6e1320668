#include "tests/support/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/slowdown.h"

namespace granary::test {
namespace {

using Clock = std::chrono::steady_clock;

struct Pipe {
  int read_end = -1;
  int write_end = -1;
};

Pipe make_pipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) abort();
  return {ends[0], ends[1]};
}

Pipe make_terminal() {
  winsize size{.ws_row = 25, .ws_col = 100, .ws_xpixel = 0, .ws_ypixel = 0};
  int master = -1, slave = -1;
  if (openpty(&master, &slave, nullptr, nullptr, &size) != 0) abort();
  fcntl(master, F_SETFD, FD_CLOEXEC);
  fcntl(slave, F_SETFD, FD_CLOEXEC);
  return {master, slave};
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

}  // namespace

Program::Program(const ProgramOptions& options) {
  std::vector<std::string> command = options.command;
  std::vector<std::string> environment{std::string("PATH=") + getenv("PATH")};
  for (const char* sanitizer : {"ASAN_OPTIONS", "UBSAN_OPTIONS"})
    if (const char* value = getenv(sanitizer))
      environment.push_back(std::string(sanitizer) + "=" + value);
  for (const auto& [name, value] : options.environment) environment.push_back(name + "=" + value);
  std::vector<char*> arguments = pointers(command);
  std::vector<char*> variables = pointers(environment);
  const Pipe in = make_pipe(), out = make_pipe();
  const Pipe err = options.on_terminal ? make_terminal() : make_pipe();
  pid_ = fork();
  if (pid_ == 0) {
    setpgid(0, 0);
    dup2(in.read_end, STDIN_FILENO);
    dup2(out.write_end, STDOUT_FILENO);
    dup2(err.write_end, STDERR_FILENO);
    execve(arguments[0], arguments.data(), variables.data());
    _exit(126);
  }
  close(in.read_end);
  close(out.write_end);
  close(err.write_end);
  out_.fd = out.read_end;
  err_.fd = err.read_end;
  out_.reader = std::thread([this] { read_into(out_); });
  err_.reader = std::thread([this] { read_into(err_); });
  ::signal(SIGPIPE, SIG_IGN);  // the program may refuse to read its input
  (void)!write(in.write_end, options.input.data(), options.input.size());
  close(in.write_end);
}

Program::~Program() {
  if (!ended_) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
  }
  out_.reader.join();
  err_.reader.join();
  close(out_.fd);
  close(err_.fd);
}

void Program::read_into(Stream& stream) {
  char block[4096];
  for (;;) {
    const ssize_t got = read(stream.fd, block, sizeof block);
    const std::lock_guard lock(mutex_);
    if (got > 0)
      stream.text.append(block, static_cast<std::size_t>(got));
    else
      stream.ended = true;  // end of file; EIO when a terminal's other side has closed
    changed_.notify_all();
    if (stream.ended) return;
  }
}

bool Program::wait_for_exit(Clock::time_point deadline) {
  const int pidfd = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
  pollfd wanted{.fd = pidfd, .events = POLLIN, .revents = 0};
  const bool exited = poll(&wanted, 1, static_cast<int>(std::max<long>(left, 0))) == 1;
  close(pidfd);
  return exited;
}

int Program::wait(std::chrono::seconds patience) {
  if (!ended_) {
    const bool exited = wait_for_exit(Clock::now() + kSlowdown * patience);
    EXPECT_TRUE(exited) << "still running after " << patience.count() << " s; stderr:\n" << err();
    if (!exited) kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
    ended_ = true;
  }
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

void Program::signal(int number) const {
  kill(pid_, number);
}

bool Program::prints(const std::string& text, std::chrono::seconds patience) {
  std::unique_lock lock(mutex_);
  const auto there = [&] {
    return out_.text.find(text) != std::string::npos || err_.text.find(text) != std::string::npos;
  };
  changed_.wait_for(lock, kSlowdown * patience,
                    [&] { return there() || (out_.ended && err_.ended); });
  return there();
}

void Program::collect_output() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kSlowdown * kPatience, [&] { return out_.ended && err_.ended; });
}

std::string Program::out() {
  const std::lock_guard lock(mutex_);
  return out_.text;
}

std::string Program::err() {
  const std::lock_guard lock(mutex_);
  return err_.text;
}

Outputs run_program(const ProgramOptions& options) {
  Program program(options);
  const int exit_code = program.wait();
  program.collect_output();
  return {exit_code, program.out(), program.err()};
}

ScratchDirectory::ScratchDirectory() {
  path_ = "/tmp/granary_test_XXXXXX";
  if (mkdtemp(path_.data()) == nullptr) abort();
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string ScratchDirectory::write(const std::string& name, const std::string& text) const {
  std::ofstream(file(name), std::ios::binary) << text;
  return file(name);
}

std::string file_text(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace granary::test
