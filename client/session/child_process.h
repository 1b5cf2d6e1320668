// Starting programs: the private server, and the server and workers of `granary up`.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "proto/contract/result.h"

namespace granary::session {

struct ChildOptions {
  std::vector<std::string> command;  // program path, arguments
  std::filesystem::path log_file;    // stdout and stderr go here (overwritten); empty: inherited
  bool output_to_stderr = false;     // stdout goes where our stderr goes: ours is for data
  bool detached = false;             // own session, survives us, stdin from /dev/null
  bool ends_with_parent = false;     // SIGTERM when we die, however we die
};

// Own process group always, so that a terminal's Ctrl-C reaches only the parent, which drains in
// order. The error says why exec failed.
Result<pid_t> start_child(const ChildOptions& options);

// Runs to the end; exit code, 128 + signal when killed.
Result<int> run_child(const ChildOptions& options);

// Directory of the running executable: granaryd and granary-worker lie beside it.
std::filesystem::path program_directory();

}  // namespace granary::session
