#include "client/session/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace granary::session {
namespace {

// Everything the child needs, made before fork: behind it only async-signal-safe calls are allowed,
// because other threads (gRPC's) may hold locks.
struct Prepared {
  std::vector<char*> arguments;
  int log_fd = -1;
  int null_fd = -1;
  int report_fd = -1;  // closed by a successful exec; else carries errno
  pid_t parent = 0;
  bool output_to_stderr = false;
  bool detached = false;
  bool ends_with_parent = false;
};

[[noreturn]] void become_child(const Prepared& prepared) {
  if (prepared.detached)
    setsid();
  else
    setpgid(0, 0);
  if (prepared.ends_with_parent) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != prepared.parent) _exit(1);  // it died before prctl
  }
  if (prepared.null_fd >= 0) dup2(prepared.null_fd, STDIN_FILENO);
  if (prepared.output_to_stderr) dup2(STDERR_FILENO, STDOUT_FILENO);
  if (prepared.log_fd >= 0) {
    dup2(prepared.log_fd, STDOUT_FILENO);
    dup2(prepared.log_fd, STDERR_FILENO);
  }
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  signal(SIGINT, SIG_DFL);
  signal(SIGPIPE, SIG_DFL);
  execv(prepared.arguments[0], prepared.arguments.data());
  const int cause = errno;
  (void)!write(prepared.report_fd, &cause, sizeof cause);
  _exit(127);
}

class Descriptors {
 public:
  int keep(int fd) {
    fds_.push_back(fd);
    return fd;
  }
  ~Descriptors() {
    for (int fd : fds_)
      if (fd >= 0) close(fd);
  }

 private:
  std::vector<int> fds_;
};

Error start_error(const std::string& program, int cause) {
  return {ErrorCode::internal, "cannot start " + program + ": " + std::strerror(cause), ""};
}

}  // namespace

std::filesystem::path program_directory() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

Result<pid_t> start_child(const ChildOptions& options) {
  Descriptors open_here;
  Prepared prepared;
  prepared.parent = getpid();
  prepared.output_to_stderr = options.output_to_stderr;
  prepared.detached = options.detached;
  prepared.ends_with_parent = options.ends_with_parent;
  for (const std::string& argument : options.command)
    prepared.arguments.push_back(const_cast<char*>(argument.c_str()));
  prepared.arguments.push_back(nullptr);
  if (!options.log_file.empty()) {
    prepared.log_fd = open_here.keep(
        open(options.log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    if (prepared.log_fd < 0) return start_error(options.command[0], errno);
  }
  if (options.detached) prepared.null_fd = open_here.keep(open("/dev/null", O_RDONLY | O_CLOEXEC));
  int report[2];
  if (pipe2(report, O_CLOEXEC) != 0) return start_error(options.command[0], errno);
  open_here.keep(report[0]);
  prepared.report_fd = report[1];
  const pid_t pid = fork();
  if (pid == 0) become_child(prepared);
  const int fork_cause = errno;
  close(report[1]);
  if (pid < 0) return start_error(options.command[0], fork_cause);
  int cause = 0;
  if (read(report[0], &cause, sizeof cause) == sizeof cause) {
    waitpid(pid, nullptr, 0);
    return start_error(options.command[0], cause);
  }
  return pid;
}

Result<int> run_child(const ChildOptions& options) {
  auto pid = start_child(options);
  if (!pid) return pid.error();
  int status = 0;
  while (waitpid(*pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace granary::session
