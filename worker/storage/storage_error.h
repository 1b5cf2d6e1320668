// What can go wrong on disk, as one exception type. Failures surface deep inside codecs and library
// callbacks, so they travel as exceptions and are caught exactly once, where a task ends
// (worker/run/run_task.cpp).
#pragma once

#include <stdexcept>
#include <string>

namespace granary::storage {

enum class StorageFault {
  disk_full,  // ENOSPC, quota or file-size limit
  missing,    // no such file
  damaged,    // checksum or structure is wrong: torn write, bit rot, not our format
  foreign,    // intact, but of another run: other scene, engine version or vector path
  io          // everything else the operating system reports
};

class StorageError : public std::runtime_error {
 public:
  StorageError(StorageFault fault, const std::string& message)
      : std::runtime_error(message), fault_(fault) {}
  StorageFault fault() const { return fault_; }

 private:
  StorageFault fault_;
};

}  // namespace granary::storage
