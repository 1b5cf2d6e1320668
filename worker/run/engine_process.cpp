#include "worker/run/engine_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>

#include "granary/v1/worker.pb.h"
#include "worker/run/accuracy_run.h"
#include "worker/run/calibrate.h"
#include "worker/run/run_task.h"
#include "worker/run/stop_signals.h"
#include "worker/storage/checksum.h"
#include "worker/storage/column_codec.h"
#include "worker/storage/storage_error.h"

namespace granary::run {
namespace {

constexpr int kExitNoTask = 2;                  // DIR/task.pb is missing or unreadable
constexpr int kExitNoOutcome = 1;               // DIR/finished.pb could not be written
constexpr std::size_t kAtomicPipeBytes = 4096;  // PIPE_BUF: a write up to this is never torn

// Dies with its parent. The kernel sends the signal when the *thread* that forked ends, so a parent
// must fork from a thread that outlives the engine. False when the parent died before the call.
bool tie_to_parent(pid_t parent) {
  if (parent == 0) return true;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  return getppid() == parent;
}

class ProgressPipe {
 public:
  ProgressPipe() {
    const int flags = fcntl(STDOUT_FILENO, F_GETFL);
    fcntl(STDOUT_FILENO, F_SETFL, flags | O_NONBLOCK);
  }

  // False when nobody reads any more.
  bool send(const v1::Progress& progress) {
    const std::string body = progress.SerializeAsString();
    storage::Bytes message;
    storage::ByteWriter writer(message);
    writer.put_text(body);
    if (message.size() > kAtomicPipeBytes) return true;
    const ssize_t written = write(STDOUT_FILENO, message.data(), message.size());
    return written >= 0 || errno != EPIPE;
  }
};

Result<v1::TaskAssignment> read_assignment(const storage::Path& path) {
  v1::TaskAssignment assignment;
  try {
    storage::FileSystem& files = storage::real_file_system();
    storage::Bytes bytes(files.size_bytes(path));
    bytes.resize(files.open(path)->read(bytes));
    if (!assignment.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
      return Error{ErrorCode::invalid_argument, path.string() + " holds no task", ""};
  } catch (const storage::StorageError& error) {
    return Error{ErrorCode::not_found, error.what(), ""};
  }
  return assignment;
}

TaskOutcome refused(const Error& error) {
  TaskOutcome outcome;
  outcome.outcome = v1::TaskFinished::ERROR;
  outcome.message = error.message;
  return outcome;
}

TaskOutcome execute(const v1::TaskAssignment& assignment, const storage::Path& directory,
                    const EngineBuild& build) {
  Result<TaskSpec> spec = make_task(assignment.scene(), build);
  if (!spec) return refused(spec.error());
  // The filling of another job (STORED) has that job's key.
  if (!assignment.filling_key().empty()) spec->filling_key = assignment.filling_key();
  spec->result_path = directory / "result.h5";
  spec->work_directory = directory;
  spec->filling_input = directory / "filling.in";
  spec->filling_output = directory / "filling.out";
  spec->time_limit_s = assignment.time_limit_s();

  ProgressPipe pipe;
  TaskCallbacks callbacks;
  callbacks.progress = [&](const v1::Progress& progress) {
    if (!pipe.send(progress)) stop_signal().store(StopRequest::release);
  };
  callbacks.log = [](std::string_view line) { std::cerr << line << '\n'; };
  TaskOutcome outcome = run_request(*spec, build.factory, callbacks, stop_signal());
  note_speed(*spec, outcome);
  return outcome;
}

void write_finished(const storage::Path& directory, const TaskOutcome& outcome) {
  v1::TaskFinished finished;
  finished.set_outcome(outcome.outcome);
  finished.set_message(outcome.message);
  *finished.mutable_result() = outcome.result;
  *finished.mutable_series() = outcome.series;
  if (outcome.published) {
    const auto digest = storage::sha256_of(storage::real_file_system(), directory / "result.h5");
    finished.mutable_artifact()->set_sha256(digest.sha256);
    finished.mutable_artifact()->set_size_bytes(digest.size_bytes);
  }
  const std::string bytes = finished.SerializeAsString();
  storage::write_atomically(storage::real_file_system(), directory / "finished.pb",
                            std::as_bytes(std::span(bytes)));
}

// Only a run that may be taken up again keeps its checkpoint.
bool may_resume(v1::TaskFinished::Outcome outcome) {
  return outcome == v1::TaskFinished::RELEASED || outcome == v1::TaskFinished::CRASHED;
}

}  // namespace

int run_engine_process(const storage::Path& directory, pid_t parent, const EngineBuild& build) {
  if (!tie_to_parent(parent)) return kExitNoOutcome;
  listen_to_stop_signals(StopRequest::cancel, StopRequest::release);
  const Result<v1::TaskAssignment> assignment = read_assignment(directory / "task.pb");
  if (!assignment) {
    std::cerr << assignment.error().message << '\n';
    return kExitNoTask;
  }
  const TaskOutcome outcome = execute(*assignment, directory, build);
  if (!outcome.message.empty()) std::cerr << outcome.message << '\n';
  try {
    write_finished(directory, outcome);
    if (!may_resume(outcome.outcome)) remove_run_files(storage::real_file_system(), directory);
  } catch (const storage::StorageError& error) {
    std::cerr << error.what() << '\n';
    return kExitNoOutcome;
  }
  return 0;
}

}  // namespace granary::run
