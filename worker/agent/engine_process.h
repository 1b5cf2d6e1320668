// One engine: this very program started again with --engine DIR, in a process group of its own, so
// that it can be stopped with everything it may have started, and so that its death is not ours.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "granary/v1/result.pb.h"
#include "proto/contract/result.h"

namespace granary::agent {

struct EngineExit {
  bool exited = false;  // else ended by a signal
  int code = 0;         // exit code or signal number
};

class EngineProcess {
 public:
  // Starts `program --engine folder --parent us`; its stdout is our progress pipe, its stderr
  // folder/engine.log.
  static Result<EngineProcess> start(const std::filesystem::path& program,
                                     const std::filesystem::path& folder);
  EngineProcess(EngineProcess&& other) noexcept;
  ~EngineProcess();  // kills the group if it is still there

  pid_t pid() const { return pid_; }

  // Blocks until the pipe closes, handing over every progress message (4-byte little-endian length,
  // then granary.v1.Progress).
  void read_progress(const std::function<void(const v1::Progress&)>& deliver);

  EngineExit wait();
  static void signal_group(pid_t group, int signal);

 private:
  EngineProcess(pid_t pid, int pipe) : pid_(pid), pipe_(pipe) {}
  pid_t pid_ = -1;
  int pipe_ = -1;
};

}  // namespace granary::agent
