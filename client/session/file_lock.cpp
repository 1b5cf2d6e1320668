#include "client/session/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace granary::session {

Result<FileLock> FileLock::acquire(const std::filesystem::path& path, int extra_flag) {
  const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0)
    return Error{ErrorCode::permission_denied, path.string() + ": " + std::strerror(errno), ""};
  int outcome = 0;
  do outcome = flock(fd, LOCK_EX | extra_flag);
  while (outcome != 0 && errno == EINTR);
  if (outcome == 0) return FileLock(fd);
  const int cause = errno;
  close(fd);
  if (cause == EWOULDBLOCK)
    return Error{ErrorCode::failed_precondition, path.string() + " is held by another process", ""};
  return Error{ErrorCode::internal, path.string() + ": " + std::strerror(cause), ""};
}

Result<FileLock> FileLock::wait(const std::filesystem::path& path) {
  return acquire(path, 0);
}

Result<FileLock> FileLock::take(const std::filesystem::path& path) {
  return acquire(path, LOCK_NB);
}

FileLock::~FileLock() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace granary::session
