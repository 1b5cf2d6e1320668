// Checksums. XXH3 finds torn and rotten data inside our own files at memory speed; SHA-256 names a
// finished artifact to the rest of the service.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "worker/storage/file_system.h"

namespace granary::storage {

std::uint64_t xxh3(std::span<const std::byte> bytes);

class RunningChecksum {
 public:
  RunningChecksum();
  ~RunningChecksum();
  RunningChecksum(RunningChecksum&&) noexcept;
  RunningChecksum& operator=(RunningChecksum&&) noexcept;
  void add(std::span<const std::byte> bytes);
  std::uint64_t value() const;  // XXH3-64 of everything added so far

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct FileDigest {
  std::string sha256;  // 64 lower-case hex digits
  std::uint64_t size_bytes = 0;
};
FileDigest sha256_of(FileSystem& files, const Path& path);

}  // namespace granary::storage
