// One server per data directory: an exclusive lock that the kernel releases however we die.
#pragma once

#include <filesystem>

#include "proto/contract/result.h"

namespace granary::server {

class DataLock {
 public:
  static Result<DataLock> take(const std::filesystem::path& data);  // FAILED_PRECONDITION: taken
  DataLock(DataLock&& other) noexcept;
  ~DataLock();

 private:
  explicit DataLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace granary::server
