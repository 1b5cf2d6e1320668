#include "worker/storage/file_system.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

StorageFault fault_of(int error) {
  if (error == ENOSPC || error == EDQUOT || error == EFBIG) return StorageFault::disk_full;
  return error == ENOENT ? StorageFault::missing : StorageFault::io;
}

[[noreturn]] void fail(std::string_view verb, const Path& path, int error = errno) {
  throw StorageError(fault_of(error), "cannot " + std::string(verb) + " " + path.string() + ": " +
                                          std::strerror(error));
}

class Descriptor {
 public:
  Descriptor(const Path& path, int flags, std::string_view verb)
      : number_(::open(path.c_str(), flags | O_CLOEXEC, 0644)), path_(path) {
    if (number_ < 0) fail(verb, path);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { ::close(number_); }
  int number() const { return number_; }
  const Path& path() const { return path_; }

  void sync() const {
    if (::fsync(number_) != 0) fail("sync", path_);
  }

 private:
  int number_;
  Path path_;
};

class PosixWritableFile : public WritableFile {
 public:
  explicit PosixWritableFile(const Path& path)
      : file_(path, O_WRONLY | O_CREAT | O_TRUNC, "create") {}

  void append(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t written = ::write(file_.number(), bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail("write", file_.path());
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }
  void sync() override { file_.sync(); }

 private:
  Descriptor file_;
};

class PosixReadableFile : public ReadableFile {
 public:
  explicit PosixReadableFile(const Path& path) : file_(path, O_RDONLY, "open") {}

  std::size_t read(std::span<std::byte> bytes) override {
    std::size_t total = 0;
    while (total < bytes.size()) {
      const ssize_t got = ::read(file_.number(), bytes.data() + total, bytes.size() - total);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail("read", file_.path());
      if (got == 0) break;
      total += static_cast<std::size_t>(got);
    }
    return total;
  }

 private:
  Descriptor file_;
};

class PosixFileSystem : public FileSystem {
 public:
  std::unique_ptr<WritableFile> create(const Path& path) override {
    return std::make_unique<PosixWritableFile>(path);
  }
  std::unique_ptr<ReadableFile> open(const Path& path) override {
    return std::make_unique<PosixReadableFile>(path);
  }
  std::uint64_t size_bytes(const Path& path) override {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) fail("look at", path);
    return static_cast<std::uint64_t>(info.st_size);
  }
  bool exists(const Path& path) override { return ::access(path.c_str(), F_OK) == 0; }
  std::vector<std::string> list(const Path& directory) override {
    std::error_code error;
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(directory, error))
      names.push_back(entry.path().filename().string());
    if (error) fail("list", directory, error.value());
    std::sort(names.begin(), names.end());
    return names;
  }
  void create_directory(const Path& path) override {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error) fail("create", path, error.value());
  }
  void rename(const Path& from, const Path& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0) fail("rename", from);
  }
  void remove(const Path& path) override {
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail("remove", path);
  }
  void sync_file(const Path& path) override { Descriptor(path, O_RDONLY, "open").sync(); }
  void sync_directory(const Path& path) override {
    Descriptor(path, O_RDONLY | O_DIRECTORY, "open").sync();
  }
};

}  // namespace

FileSystem& real_file_system() {
  static PosixFileSystem files;
  return files;
}

void write_atomically(FileSystem& files, const Path& path, std::span<const std::byte> bytes) {
  const Path temporary = path.string() + ".tmp";
  try {
    auto file = files.create(temporary);
    file->append(bytes);
    file->sync();
  } catch (const StorageError&) {
    files.remove(temporary);  // on a full disk its space is the first to be given back
    throw;
  }
  files.rename(temporary, path);
  files.sync_directory(directory_of(path));
}

Path directory_of(const Path& path) {
  return path.has_parent_path() ? path.parent_path() : Path(".");
}

}  // namespace granary::storage
