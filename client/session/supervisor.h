// `granary up`: one server and its local workers as children of this process. A worker that dies is
// started again at once (with growing delays when it keeps dying young), a server that crashes too;
// SIGINT or SIGTERM drains: workers hand back their tasks and leave, then the server leaves.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/session/data_directory.h"
#include "client/session/restart_policy.h"
#include "proto/contract/result.h"

namespace granary::session {

struct SupervisorOptions {
  std::string listen;  // unix:PATH or HOST:PORT; empty: the socket of the data directory
  int worker_count = 1;
  int idle_exit_s = 0;  // 0: never. Else the server leaves by itself, and all with it
  std::string log_level = "info";
  bool wait_for_predecessor = false;  // a private server may still be leaving
};

class Supervisor {
 public:
  using Notice = std::function<void(std::string_view)>;

  Supervisor(DataDirectory directory, SupervisorOptions options, Notice notice);

  // Returns when everything has left. `on_ready(address)` is called once the server serves.
  // Blocks SIGINT, SIGTERM, SIGHUP and SIGCHLD of the process: call before other threads start.
  Status run(const std::function<void(const std::string& address)>& on_ready);

 private:
  using Clock = std::chrono::steady_clock;
  struct Child {
    std::vector<std::string> command;
    std::string what;  // "worker 2"
    int pid = -1;      // -1: not running
    Clock::time_point started;
    std::optional<Clock::time_point> restart_at;
    RestartPolicy policy;
  };

  Status prepare();
  Status start(Child& child);
  Status start_server();
  static Error refusal();
  void start_workers();
  void supervise();
  // Waits for a signal until `deadline`: its number, 0 when none came.
  int next_signal(Clock::time_point deadline);
  Clock::time_point next_restart() const;
  void restart_due();
  void reap();
  void note_death(Child& child, int wait_status);
  void drain();
  void stop(std::vector<Child*> children, std::chrono::seconds grace);
  bool server_left() const { return server_.pid < 0 && !server_.restart_at; }

  DataDirectory directory_;
  SupervisorOptions options_;
  Notice notice_;
  std::string address_;
  Child server_;
  std::vector<Child> workers_;
  bool draining_ = false;
  bool server_refused_ = false;  // its settings; it would do so again
};

// The address by which local workers reach a server that listens on `listen`.
std::string local_address_of(const std::string& listen);

}  // namespace granary::session
