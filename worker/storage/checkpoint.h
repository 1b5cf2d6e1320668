// A checkpoint: everything a run needs to go on bitwise as if it had never stopped - the engine's
// snapshot, the run layer's own counters and the list of sealed frame segments before it.
//
//   file     := "GRNCKP1\n", section *, u32 "CSUM", u32 0, u64 8, u64 XXH3-64 of all bytes before
//   "CSUM" section  := u32 tag, u32 0, u64 payload bytes, payload "IDEN"   := text scene key, text
//   engine version, text vector path "SEGM"   := u32 count, (text name, u32 index, u64 first frame,
//   u64 frames, u64 bytes, u64 XXH3) * "RUNS"   := bytes of the run layer
//   (worker/run/run_record.cpp) "ENGI"   := columns of the engine (column_codec.h; text = u32
//   length, bytes)
//
// In a run's directory the newest is `checkpoint`, the one before it `checkpoint.previous`: the old
// one is never touched before the new one is durable.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "worker/core/column.h"
#include "worker/storage/file_system.h"
#include "worker/storage/run_identity.h"
#include "worker/storage/segment.h"

namespace granary::storage {

struct Checkpoint {
  RunIdentity identity;
  std::vector<SegmentInfo> segments;
  Bytes run;  // opaque here
  core::State engine;
};

// One file, written atomically. The file of a stored filling has the same format.
void write_checkpoint_file(FileSystem& files, const Path& path, const Checkpoint& checkpoint);
// StorageError: missing, damaged, or foreign when `identity` differs.
Checkpoint read_checkpoint_file(FileSystem& files, const Path& path, const RunIdentity& identity);

void save_checkpoint(FileSystem& files, const Path& directory, const Checkpoint& checkpoint);

// Tries the newest, then the one before; a checkpoint counts only when `accept` (which may restore
// segments from it) does not throw StorageError. nullopt when none is usable; `report` is told why
// each was passed over, and not called when there was none at all.
std::optional<Checkpoint> load_checkpoint(FileSystem& files, const Path& directory,
                                          const RunIdentity& identity,
                                          const std::function<void(const Checkpoint&)>& accept,
                                          const std::function<void(const std::string&)>& report);

void remove_checkpoints(FileSystem& files, const Path& directory);

}  // namespace granary::storage
