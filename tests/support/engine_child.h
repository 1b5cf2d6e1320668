// An engine process as its parent sees it: started on a directory, read, signalled, waited for.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "granary/v1/result.pb.h"

namespace granary::testing {

class EngineChild {
 public:
  EngineChild(const std::string& program, const std::filesystem::path& directory);
  ~EngineChild();  // kills what still runs

  std::optional<v1::Progress> read_progress();  // nullopt once the pipe is closed
  std::vector<v1::Progress> read_all_progress();
  void close_pipe();
  void signal(int number);
  int wait();  // exit code, or -signal
  std::string log() const;
  pid_t pid() const { return pid_; }

 private:
  std::filesystem::path directory_;
  pid_t pid_ = -1;
  int pipe_ = -1;
};

// Starts the engine from a process that ends as soon as the engine has reported once.
pid_t spawn_through_dying_parent(const std::string& program,
                                 const std::filesystem::path& directory);
bool is_gone_within(pid_t pid, std::chrono::seconds deadline);

}  // namespace granary::testing
