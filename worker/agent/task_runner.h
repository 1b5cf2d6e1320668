// One task from assignment to acknowledgement, on a thread of its own: folder, engine process,
// progress, upload, outcome. The outcome is kept and told again until the server has stored it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "granary/v1/worker.grpc.pb.h"
#include "worker/agent/task_files.h"

namespace granary::agent {

struct TaskEnvironment {
  std::filesystem::path program;  // started as the engine
  std::filesystem::path folder;   // of this task; removed at the end
  const ServerPeer& server;
  std::function<void(const v1::WorkerMessage&)> send;
  std::function<void(const std::string& task)> gone;  // acknowledged or dropped; thread is ending
};

class TaskRunner {
 public:
  TaskRunner(v1::TaskAssignment assignment, TaskEnvironment environment);
  ~TaskRunner();  // drops the task

  v1::HeldTask held() const;
  void cancel();        // stops the engine; outcome CANCELLED
  void release();       // drain: the engine checkpoints and leaves; outcome RELEASED
  void drop();          // not ours any more: stop, say nothing
  void acknowledged();  // the outcome is stored
  void say_again();     // after a reconnect: tells the outcome if there is one

 private:
  enum class Wish { run, cancel, release, drop };
  void run();
  v1::TaskFinished execute();
  v1::TaskFinished judge(bool exited, int code);
  bool upload_result(v1::TaskFinished& finished);
  void wish(Wish wish, int signal);
  void enforce(pid_t group);
  void share_while_running(TaskFiles& files);

  v1::TaskAssignment assignment_;
  TaskEnvironment environment_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Wish wish_ = Wish::run;
  bool acknowledged_ = false;
  pid_t group_ = -1;  // of the running engine
  std::optional<v1::WorkerMessage> outcome_;
  std::thread thread_;
};

}  // namespace granary::agent
