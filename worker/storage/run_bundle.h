// A checkpoint and the frame segments it counts on, as one file: how a run moves to another worker.
// May be packed while the engine goes on: sealed segments never change, and the checkpoint is read as
// one piece.
//
//   file  := "GRNBND1\n", entry *
//   entry := u32 length, name, u64 bytes, u64 XXH3 of the bytes, the bytes
// The first entry is "checkpoint"; the others are the segments it lists. No name holds a path.
#pragma once

#include "worker/storage/file_system.h"

namespace granary::storage {

// StorageError(missing) when there is no checkpoint yet.
void pack_run(FileSystem& files, const Path& directory, const Path& bundle);

// Makes `directory` one from which the run resumes. StorageError(damaged) when the bundle is not
// intact; then the directory holds no checkpoint, and the run starts from the beginning.
void unpack_run(FileSystem& files, const Path& bundle, const Path& directory);

}  // namespace granary::storage
