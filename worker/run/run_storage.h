// One run's files: frames into segments, checkpoints, and at the end the result file. Does nothing
// when the task names no result path.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "worker/run/run_record.h"
#include "worker/run/task.h"
#include "worker/storage/checkpoint.h"
#include "worker/storage/frame_store.h"
#include "worker/storage/result_content.h"

namespace granary::run {

using Log = std::function<void(std::string_view)>;

class RunStorage {
 public:
  RunStorage(storage::FileSystem& files, const TaskSpec& spec, Log log);

  struct Resumed {
    RunRecord record;
    core::State engine;
    core::State mark;
  };
  // The newest usable checkpoint of this very run; without one the directory is left clean for a
  // start from the beginning. Says in the log why a checkpoint was passed over.
  std::optional<Resumed> resume();
  void start_over();

  void append_frame(const storage::FrameView& frame);
  void drop_frames_from(std::uint64_t frame_index);
  // Frames so far become durable (StorageError when they cannot). A checkpoint that cannot be
  // written is logged and the run goes on: the one before it is still good.
  // `mark` is the engine's state at record.mark; null when that is where it stands.
  void save(const RunRecord& record, core::State engine, const core::State* mark);
  void publish(const storage::ResultContent& content);

  bool active() const { return active_; }

 private:
  storage::FileSystem& files_;
  bool active_;
  storage::Path result_path_;
  storage::Path directory_;
  storage::RunIdentity identity_;
  storage::FrameStore frames_;
  Log log_;
};

// A filling shared between runs: the engine's state and the CPU seconds it took.
struct StoredFilling {
  core::State state;
  double cpu_s = 0;
};
std::optional<StoredFilling> load_filling(storage::FileSystem& files, const TaskSpec& spec,
                                          const Log& log);
void save_filling(storage::FileSystem& files, const TaskSpec& spec, const StoredFilling& filling);

}  // namespace granary::run
