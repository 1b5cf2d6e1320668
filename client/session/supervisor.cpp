#include "client/session/supervisor.h"

#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstring>

#include "client/session/child_process.h"
#include "client/session/file_lock.h"
#include "client/session/private_server.h"

namespace granary::session {
namespace {

constexpr std::chrono::seconds kServerStart{30};
constexpr std::chrono::milliseconds kStartPoll{50};
constexpr std::chrono::milliseconds kProbeTimeout{500};
constexpr std::chrono::hours kIdle{1};
// A worker checkpoints and hands back its task; the server then only closes its database.
constexpr std::chrono::seconds kWorkerGrace{30};
constexpr std::chrono::seconds kServerGrace{20};

sigset_t watched_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) sigaddset(&set, signal);
  return set;
}

std::string describe_end(int wait_status) {
  if (WIFSIGNALED(wait_status))
    return std::string("was ended by a signal: ") + strsignal(WTERMSIG(wait_status));
  return "exited with " + std::to_string(WEXITSTATUS(wait_status));
}

}  // namespace

std::string local_address_of(const std::string& listen) {
  for (const char* any : {"0.0.0.0:", "[::]:", "*:"})
    if (listen.rfind(any, 0) == 0) return "127.0.0.1:" + listen.substr(std::strlen(any));
  return listen;
}

Supervisor::Supervisor(DataDirectory directory, SupervisorOptions options, Notice notice)
    : directory_(std::move(directory)), options_(std::move(options)), notice_(std::move(notice)) {}

Status Supervisor::run(const std::function<void(const std::string&)>& on_ready) {
  const auto lock = options_.wait_for_predecessor ? FileLock::wait(directory_.supervisor_lock())
                                                  : FileLock::take(directory_.supervisor_lock());
  if (!lock && lock.error().code == ErrorCode::failed_precondition)
    return Error{ErrorCode::failed_precondition,
                 "data directory " + directory_.path().string() +
                     " is in use by another granary up (server " + directory_.server_address() +
                     ")",
                 ""};
  if (!lock) return lock.error();
  const sigset_t watched = watched_signals();
  pthread_sigmask(SIG_BLOCK, &watched, nullptr);
  if (auto ready = prepare(); !ready) return ready.error();
  const Status served = start_server();
  if (served && !draining_) {
    start_workers();
    on_ready(address_);
    supervise();
  }
  drain();
  directory_.forget_server();
  return server_refused_ ? refusal() : served;
}

Status Supervisor::prepare() {
  auto socket = directory_.socket_address();
  if (!socket) return socket.error();
  const std::string listen = options_.listen.empty() ? *socket : options_.listen;
  address_ = local_address_of(listen);
  const std::filesystem::path programs = program_directory();
  server_.what = "server";
  server_.command = {
      programs / "granaryd", "--data",          directory_.path(), "--listen", listen,
      "--log-level",         options_.log_level};
  if (options_.idle_exit_s > 0) {
    server_.command.push_back("--idle-exit");
    server_.command.push_back(std::to_string(options_.idle_exit_s));
  }
  for (int number = 1; number <= options_.worker_count; ++number) {
    Child& worker = workers_.emplace_back();
    worker.what = "worker " + std::to_string(number);
    worker.command = {
        programs / "granary-worker",        "--server", address_, "--slots", "1", "--work-dir",
        directory_.worker_directory(number)};
  }
  return directory_.write_server_address(address_);
}

Status Supervisor::start(Child& child) {
  child.restart_at.reset();
  child.started = Clock::now();
  auto pid = start_child({.command = child.command,
                          .log_file = {},
                          .output_to_stderr = true,
                          .ends_with_parent = true});
  if (!pid) return pid.error();
  child.pid = *pid;
  return Done{};
}

Error Supervisor::refusal() {
  return {ErrorCode::invalid_argument, "the server refused its settings, see above", ""};
}

Status Supervisor::start_server() {
  // Otherwise that one would be taken for ours, and the workers would work for it.
  if (serving_connection(address_, kProbeTimeout))
    return Error{ErrorCode::invalid_argument,
                 "another server serves " + address_ + ": choose another address", "listen"};
  if (auto started = start(server_); !started) return started.error();
  const auto deadline = Clock::now() + kServerStart;
  while (!serving_connection(address_, kProbeTimeout)) {
    const int signal = next_signal(Clock::now() + kStartPoll);
    if (signal == SIGCHLD) reap();
    if (server_.pid < 0 && server_refused_) return refusal();
    if (server_.pid < 0)
      return Error{ErrorCode::unavailable, "the server stopped while starting", ""};
    if (signal != 0 && signal != SIGCHLD) {
      draining_ = true;
      return Done{};
    }
    if (Clock::now() > deadline)
      return Error{ErrorCode::unavailable, "the server did not come up in time", ""};
  }
  return Done{};
}

void Supervisor::start_workers() {
  for (Child& worker : workers_) {
    std::error_code failure;
    std::filesystem::create_directories(worker.command.back(), failure);
    if (auto started = start(worker); !started) notice_(started.error().message);
  }
}

int Supervisor::next_signal(Clock::time_point deadline) {
  const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
  const auto left_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(left).count();
  const timespec timeout{left_ns / 1'000'000'000, left_ns % 1'000'000'000};
  const sigset_t watched = watched_signals();
  return std::max(sigtimedwait(&watched, nullptr, &timeout), 0);
}

Supervisor::Clock::time_point Supervisor::next_restart() const {
  auto earliest = Clock::now() + kIdle;
  if (server_.restart_at) earliest = std::min(earliest, *server_.restart_at);
  for (const Child& worker : workers_)
    if (worker.restart_at) earliest = std::min(earliest, *worker.restart_at);
  return earliest;
}

void Supervisor::supervise() {
  while (!draining_ && !server_left()) {
    const int signal = next_signal(next_restart());
    if (signal == SIGCHLD) reap();
    if (signal != 0 && signal != SIGCHLD) draining_ = true;
    if (!draining_) restart_due();
  }
}

void Supervisor::restart_due() {
  const auto restart = [this](Child& child) {
    if (!child.restart_at || *child.restart_at > Clock::now()) return;
    if (auto started = start(child); !started) {
      notice_(started.error().message);
      child.restart_at = Clock::now() + std::chrono::seconds(30);
    }
  };
  restart(server_);
  for (Child& worker : workers_) restart(worker);
}

void Supervisor::reap() {
  int wait_status = 0;
  for (pid_t pid = waitpid(-1, &wait_status, WNOHANG); pid > 0;
       pid = waitpid(-1, &wait_status, WNOHANG)) {
    if (server_.pid == pid) note_death(server_, wait_status);
    for (Child& worker : workers_)
      if (worker.pid == pid) note_death(worker, wait_status);
  }
}

void Supervisor::note_death(Child& child, int wait_status) {
  child.pid = -1;
  const bool left = WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0;
  if (draining_ || (left && &child == &server_)) return;
  if (&child == &server_ && WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == static_cast<int>(ExitCode::usage)) {
    server_refused_ = true;  // and would again
    return;
  }
  const std::chrono::duration<double> lived = Clock::now() - child.started;
  const double delay_s = child.policy.delay_after_s(lived.count());
  child.restart_at = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(delay_s));
  notice_(child.what + " " + describe_end(wait_status) + "; starting it again");
}

void Supervisor::drain() {
  draining_ = true;
  std::vector<Child*> workers;
  for (Child& worker : workers_) workers.push_back(&worker);
  stop(workers, kWorkerGrace);
  stop({&server_}, kServerGrace);
}

void Supervisor::stop(std::vector<Child*> children, std::chrono::seconds grace) {
  const auto running = [&] {
    return std::any_of(children.begin(), children.end(), [](Child* c) { return c->pid > 0; });
  };
  const auto signal_all = [&](int signal) {
    for (Child* child : children)
      if (child->pid > 0) kill(child->pid, signal);
  };
  signal_all(SIGTERM);
  const auto deadline = Clock::now() + grace;
  while (running() && Clock::now() < deadline) {
    const int signal = next_signal(deadline);
    if (signal == SIGCHLD) reap();
    if (signal != 0 && signal != SIGCHLD) break;  // asked again: no more patience
  }
  signal_all(SIGKILL);
  while (running()) {
    (void)next_signal(Clock::now() + std::chrono::seconds(1));
    reap();
  }
}

}  // namespace granary::session
