// An exclusive lock on a file. The kernel drops it when the process dies, however it dies.
#pragma once

#include <filesystem>

#include "proto/contract/result.h"

namespace granary::session {

class FileLock {
 public:
  // Creates the file if need be and waits until nobody else holds it. Not inherited by children.
  static Result<FileLock> wait(const std::filesystem::path& path);
  // FAILED_PRECONDITION when somebody holds it.
  static Result<FileLock> take(const std::filesystem::path& path);

  FileLock(FileLock&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  explicit FileLock(int fd) : fd_(fd) {}
  static Result<FileLock> acquire(const std::filesystem::path& path, int extra_flag);
  int fd_;
};

}  // namespace granary::session
