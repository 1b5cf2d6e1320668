#include "worker/agent/task_runner.h"

#include <spdlog/spdlog.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <deque>
#include <fstream>
#include <sstream>

#include "worker/agent/engine_process.h"
#include "worker/agent/upload.h"

namespace granary::agent {
namespace {

using Outcome = v1::TaskFinished;
using namespace std::chrono_literals;

constexpr auto kGrace = 600ms;           // from the polite signal to SIGKILL: cancel takes < 1 s
constexpr auto kReleaseGrace = 20s;      // a checkpoint of a large job is written in this time
constexpr double kTimeLimitMarginS = 5;  // the engine enforces its limit itself; this is the net
constexpr auto kShareInterval = 1s;  // how soon a new checkpoint or filling is sent on
constexpr std::size_t kLogLines = 100;

std::vector<std::string> last_lines(const std::filesystem::path& file, std::size_t count) {
  std::ifstream in(file);
  std::deque<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line.substr(0, 2000));
    if (lines.size() > count) lines.pop_front();
  }
  return {lines.begin(), lines.end()};
}

bool write_file(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream out(file, std::ios::binary);
  out << bytes;
  return static_cast<bool>(out.flush());
}

}  // namespace

TaskRunner::TaskRunner(v1::TaskAssignment assignment, TaskEnvironment environment)
    : assignment_(std::move(assignment)),
      environment_(std::move(environment)),
      thread_([this] { run(); }) {}

TaskRunner::~TaskRunner() {
  drop();
  if (thread_.joinable()) thread_.join();
}

v1::HeldTask TaskRunner::held() const {
  v1::HeldTask held;
  held.set_task(assignment_.task());
  held.set_fencing_token(assignment_.fencing_token());
  return held;
}

void TaskRunner::wish(Wish wish, int signal) {
  std::lock_guard lock(mutex_);
  if (wish_ == Wish::drop) return;
  wish_ = wish;
  EngineProcess::signal_group(group_, signal);
  changed_.notify_all();
}

void TaskRunner::cancel() {
  wish(Wish::cancel, SIGINT);
}
void TaskRunner::release() {
  wish(Wish::release, SIGTERM);
}
void TaskRunner::drop() {
  wish(Wish::drop, SIGKILL);
}

void TaskRunner::acknowledged() {
  std::lock_guard lock(mutex_);
  acknowledged_ = true;
  changed_.notify_all();
}

void TaskRunner::say_again() {
  std::lock_guard lock(mutex_);
  if (outcome_) environment_.send(*outcome_);
}

void TaskRunner::run() {
  v1::WorkerMessage message;
  v1::TaskFinished& finished = *message.mutable_finished() = execute();
  finished.set_task(assignment_.task());
  finished.set_fencing_token(assignment_.fencing_token());
  if (finished.outcome() == Outcome::COMPLETE && !upload_result(finished))
    finished.set_outcome(Outcome::CRASHED);
  {
    std::unique_lock lock(mutex_);
    if (wish_ != Wish::drop) {
      outcome_ = message;
      environment_.send(message);
      changed_.wait(lock, [this] { return acknowledged_ || wish_ == Wish::drop; });
    }
  }
  std::error_code ignored;
  std::filesystem::remove_all(environment_.folder, ignored);
  environment_.gone(assignment_.task());
}

v1::TaskFinished TaskRunner::execute() {
  v1::TaskFinished failed;
  failed.set_outcome(Outcome::CRASHED);
  std::error_code error;
  std::filesystem::create_directories(environment_.folder, error);
  if (!write_file(environment_.folder / "task.pb", assignment_.SerializeAsString())) {
    failed.set_message("cannot write in the work directory");
    return failed;
  }
  TaskFiles files(assignment_, environment_.folder, environment_.server, environment_.send);
  files.fetch();
  auto engine = EngineProcess::start(environment_.program, environment_.folder);
  if (!engine) {
    failed.set_message(engine.error().message);
    return failed;
  }
  std::thread enforcer, sharer;
  {
    std::lock_guard lock(mutex_);
    group_ = engine->pid();
    // A wish that came before the process existed reached nobody.
    if (wish_ != Wish::run) EngineProcess::signal_group(group_, SIGKILL);
    enforcer = std::thread([this, group = group_] { enforce(group); });
    sharer = std::thread([this, &files] { share_while_running(files); });
  }
  engine->read_progress([this](const v1::Progress& progress) {
    v1::WorkerMessage message;
    message.mutable_progress()->set_task(assignment_.task());
    message.mutable_progress()->set_fencing_token(assignment_.fencing_token());
    *message.mutable_progress()->mutable_progress() = progress;
    environment_.send(message);
  });
  const EngineExit exit = engine->wait();
  {
    std::lock_guard lock(mutex_);
    group_ = -1;
    changed_.notify_all();
  }
  enforcer.join();
  sharer.join();
  v1::TaskFinished finished = judge(exit.exited, exit.code);
  const bool somebody_continues =
      finished.outcome() == Outcome::RELEASED || finished.outcome() == Outcome::CRASHED;
  if (somebody_continues || finished.outcome() == Outcome::COMPLETE) files.share();
  for (std::string& line : last_lines(environment_.folder / "engine.log", kLogLines))
    finished.add_log_lines(std::move(line));
  return finished;
}

// Kills what does not follow a polite signal, and what runs far beyond its time limit.
void TaskRunner::enforce(pid_t group) {
  std::unique_lock lock(mutex_);
  const auto ended_or_wished = [this] { return group_ == -1 || wish_ != Wish::run; };
  if (assignment_.time_limit_s() > 0) {
    const std::chrono::duration<double> limit(assignment_.time_limit_s() + kTimeLimitMarginS);
    if (!changed_.wait_for(lock, limit, ended_or_wished))
      return EngineProcess::signal_group(group, SIGKILL);
  } else {
    changed_.wait(lock, ended_or_wished);
  }
  const auto ended = [this] { return group_ == -1; };
  const bool gone = wish_ == Wish::release ? changed_.wait_for(lock, kReleaseGrace, ended)
                                           : changed_.wait_for(lock, kGrace, ended);
  if (!gone) EngineProcess::signal_group(group, SIGKILL);
}

void TaskRunner::share_while_running(TaskFiles& files) {
  std::unique_lock lock(mutex_);
  while (group_ != -1) {
    changed_.wait_for(lock, kShareInterval, [this] { return group_ == -1; });
    if (group_ == -1) return;
    lock.unlock();
    files.share();
    lock.lock();
  }
}

v1::TaskFinished TaskRunner::judge(bool exited, int code) {
  v1::TaskFinished finished;
  std::ifstream in(environment_.folder / "finished.pb", std::ios::binary);
  const bool told =
      in && finished.ParseFromIstream(&in) && finished.outcome() != Outcome::OUTCOME_UNSPECIFIED;
  std::lock_guard lock(mutex_);
  // What was asked for wins over what the engine managed to say, unless it was already through.
  if (told && (finished.outcome() == Outcome::COMPLETE || wish_ != Wish::cancel)) return finished;
  if (!told) finished.Clear();
  if (wish_ == Wish::cancel) {
    finished.set_outcome(Outcome::CANCELLED);
    finished.set_message("cancelled");
  } else if (wish_ == Wish::release) {
    finished.set_outcome(Outcome::RELEASED);
    finished.set_message("the worker is draining");
  } else {
    std::ostringstream what;
    what << "the engine " << (exited ? "exited with code " : "was ended by signal ") << code;
    finished.set_outcome(Outcome::CRASHED);
    finished.set_message(what.str());
  }
  return finished;
}

bool TaskRunner::upload_result(v1::TaskFinished& finished) {
  const UploadTask task{assignment_.task(), assignment_.fencing_token(), v1::UploadChunk::RESULT};
  for (auto pause = 100ms;; pause = std::min<std::chrono::milliseconds>(2 * pause, 5s)) {
    auto artifact = upload_file(environment_.server, task, environment_.folder / "result.h5");
    if (artifact) {
      *finished.mutable_artifact() = *artifact;
      return true;
    }
    const ErrorCode code = artifact.error().code;
    spdlog::warn("event=upload_failed task={} job={} reason=\"{}\"", assignment_.task(),
                 assignment_.job(), artifact.error().message);
    if (code != ErrorCode::unavailable && code != ErrorCode::resource_exhausted &&
        code != ErrorCode::cancelled) {
      finished.set_message("upload: " + artifact.error().message);
      return false;
    }
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, pause, [this] { return wish_ == Wish::drop; })) return false;
  }
}

}  // namespace granary::agent
