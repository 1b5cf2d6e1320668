// Makes a result file of what an unfinished run left behind, when nobody is going to resume it:
// every intact frame of every segment, with the scene they belong to, and no values.
#pragma once

#include <cstdint>

#include "worker/storage/file_system.h"

namespace granary::storage {

// Returns the number of frames saved. StorageError(missing) when there is no intact segment.
std::uint64_t salvage_run(FileSystem& files, const Path& directory, const Path& result_path);

}  // namespace granary::storage
