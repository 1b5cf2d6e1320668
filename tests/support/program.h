// Runs a real program under test: arguments, environment and stdin in, exit code and both outputs
// out. Nothing waits without a deadline.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace granary::test {

struct ProgramOptions {
  std::vector<std::string> command;
  std::map<std::string, std::string> environment;  // added to PATH and what sanitizers read
  std::string input;                               // on stdin
  bool on_terminal = false;                        // stderr is a 100-column pseudo-terminal
};

class Program {
 public:
  static constexpr std::chrono::seconds kPatience{20};

  explicit Program(const ProgramOptions& options);
  ~Program();  // kills what still runs
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // Exit code, or 128 + signal. Fails the test and kills the program after the deadline.
  int wait(std::chrono::seconds patience = kPatience);
  void signal(int number) const;
  pid_t pid() const { return pid_; }

  // True once stderr or stdout contains `text`.
  bool prints(const std::string& text, std::chrono::seconds patience = kPatience);

  std::string out();
  std::string err();
  // After the exit: until both outputs have ended too.
  void collect_output();

 private:
  struct Stream {
    int fd = -1;
    std::string text;
    bool ended = false;
    std::thread reader;
  };
  void read_into(Stream& stream);
  bool wait_for_exit(std::chrono::steady_clock::time_point deadline);

  pid_t pid_ = -1;
  int status_ = -1;
  bool ended_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  Stream out_;
  Stream err_;
};

struct Outputs {
  int exit_code;
  std::string out;
  std::string err;
};
Outputs run_program(const ProgramOptions& options);

// A directory of its own, removed at the end.
class ScratchDirectory {
 public:
  ScratchDirectory();
  ~ScratchDirectory();
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  std::string write(const std::string& name, const std::string& text) const;

 private:
  std::string path_;
};

std::string file_text(const std::string& path);

}  // namespace granary::test
