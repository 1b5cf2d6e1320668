#include "client/session/part_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace granary::session {
namespace {

namespace fs = std::filesystem;

Error file_error(const fs::path& path) {
  return {ErrorCode::failed_precondition, path.string() + ": " + std::strerror(errno), ""};
}

}  // namespace

fs::path with_suffix(const fs::path& file, const char* suffix) {
  fs::path path = file;
  path += suffix;
  return path;
}

Result<PartFile> PartFile::open(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return file_error(path);
  return PartFile(fd, path);
}

PartFile::PartFile(PartFile&& other) noexcept : fd_(other.fd_), path_(std::move(other.path_)) {
  other.fd_ = -1;
}

PartFile::~PartFile() {
  if (fd_ >= 0) ::close(fd_);
}

std::uint64_t PartFile::size_bytes() const {
  struct stat facts {};
  return ::fstat(fd_, &facts) == 0 ? static_cast<std::uint64_t>(facts.st_size) : 0;
}

Status PartFile::write_at(std::uint64_t offset_bytes, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset_bytes));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return file_error(path_);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset_bytes += static_cast<std::uint64_t>(written);
  }
  return Done{};
}

Status PartFile::empty() {
  return ::ftruncate(fd_, 0) == 0 ? Status(Done{}) : file_error(path_);
}

Status PartFile::sync() {
  return ::fsync(fd_) == 0 ? Status(Done{}) : file_error(path_);
}

}  // namespace granary::session
