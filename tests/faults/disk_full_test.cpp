// The disk is full from a chosen moment on. The task ends with a clear outcome that may be tried
// again, keeps its last good checkpoint, publishes nothing half, and goes on from there once there
// is space.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "tests/support/faulty_file_system.h"
#include "tests/support/sample_result.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/toy_simulation.h"
#include "worker/run/run_task.h"
#include "worker/storage/storage_error.h"
#include "worker/storage/verify.h"

// Under the address sanitizer: what HDF5 itself leaks when a close fails is not ours to free.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}

namespace granary::run {
namespace {

using namespace granary::testing;

TaskSpec spec_in(const TemporaryDirectory& directory) {
  TaskSpec spec;
  spec.scene = toy_scene();
  spec.scene_key = "key";
  spec.work_directory = directory / "run";
  spec.result_path = directory / "run" / "result.h5";
  spec.checkpoint_interval_s = 0;
  return spec;
}

TEST(DiskFull, during_a_run_ends_it_with_a_clear_message_and_it_goes_on_later) {
  TemporaryDirectory calm;
  const StopSignal stop{StopRequest::none};
  const std::string hash = run_task(spec_in(calm), toy_factory(), {}, stop).result.state_hash();
  int with_checkpoint = 0;
  for (const std::uint64_t at : {1, 5, 20, 50, 100, 150, 200}) {
    TemporaryDirectory directory;
    const TaskSpec spec = spec_in(directory);
    FaultyFileSystem files(FaultyFileSystem::Fault::disk_full, at, directory / "scratch");
    const TaskOutcome full = run_task(spec, toy_factory(), {}, stop, files);
    EXPECT_EQ(full.outcome, v1::TaskFinished::CRASHED);
    EXPECT_NE(full.message.find("No space left on device"), std::string::npos) << full.message;
    EXPECT_FALSE(std::filesystem::exists(spec.result_path));

    std::string log;
    TaskCallbacks callbacks;
    callbacks.log = [&](std::string_view line) { log += line; };
    const TaskOutcome later = run_task(spec, toy_factory(), callbacks, stop);
    EXPECT_EQ(later.outcome, v1::TaskFinished::COMPLETE) << later.message;
    EXPECT_EQ(later.result.state_hash(), hash);
    if (log.find("resumed at") != std::string::npos) ++with_checkpoint;
  }
  EXPECT_GE(with_checkpoint, 4) << "it never went on from a checkpoint";
}

// Below the seam HDF5 writes by itself; a limit on the size of files stands in for the disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t byte_count) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{byte_count, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(DiskFull, while_the_result_file_is_written_leaves_neither_a_result_nor_a_leftover) {
  const std::vector<double> big(100000, 1.5);
  for (const rlim_t limit : {100u, 5000u, 100000u, 700000u}) {
    TemporaryDirectory directory;
    try {
      const FileSizeLimit guard(limit);
      storage::ResultWriter writer(storage::real_file_system(), directory / "r.h5");
      writer.add_frame(
          {0, 0, "", {core::make_column<double>("x_m", "m", std::span<const double>(big))}});
      writer.add_content(sample_content());
      writer.commit();
      ADD_FAILURE() << "wrote 800 kB into a file of at most " << limit;
    } catch (const storage::StorageError& error) {
      EXPECT_EQ(error.fault(), storage::StorageFault::disk_full) << error.what();
    }
    EXPECT_TRUE(std::filesystem::is_empty(directory.path())) << "limit " << limit;
  }
}

// HDF5 keeps a file whose close failed half open, and would crash on it at exit.
TEST(DiskFull, while_the_result_file_is_closed_still_lets_the_process_exit) {
  TemporaryDirectory directory;
  const pid_t child = fork();
  if (child == 0) {
    const FileSizeLimit guard(5000);
    try {
      storage::ResultWriter writer(storage::real_file_system(), directory / "r.h5");
      writer.add_content(sample_content());
      writer.commit();
    } catch (const storage::StorageError&) {
      std::exit(7);
    }
    std::exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

}  // namespace
}  // namespace granary::run
