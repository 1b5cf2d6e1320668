#include "tests/support/faulty_file_system.h"

#include <sys/stat.h>

#include <filesystem>

#include "worker/storage/storage_error.h"

namespace granary::testing {
namespace {

using storage::Path;
using storage::StorageError;
using storage::StorageFault;

class CountedFile : public storage::WritableFile {
 public:
  CountedFile(FaultyFileSystem& files, std::unique_ptr<storage::WritableFile> file, Path path)
      : files_(files), file_(std::move(file)), path_(std::move(path)) {}
  void append(std::span<const std::byte> bytes) override { files_.append(*file_, path_, bytes); }
  void sync() override { files_.sync(*file_, path_); }

 private:
  FaultyFileSystem& files_;
  std::unique_ptr<storage::WritableFile> file_;
  Path path_;
};

// Files keep their inode when they are renamed.
std::string inode_of(const Path& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return "";
  return std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino);
}

}  // namespace

FaultyFileSystem::FaultyFileSystem(Fault fault, std::uint64_t at, Path scratch)
    : fault_(fault), at_(at), scratch_(std::move(scratch)) {
  real_.create_directory(scratch_);
}

void FaultyFileSystem::count_operation() {
  if (operations_++ < at_ || fault_ == Fault::none) return;
  if (fault_ == Fault::disk_full)
    throw StorageError(StorageFault::disk_full, "No space left on device");
  throw StorageError(StorageFault::io, "the power is gone");
}

void FaultyFileSystem::remember(const Path& path, std::function<void()> undo) {
  undo_.push_back({storage::directory_of(path), std::move(undo)});
}

// A second name for the file, so that its removal or replacement can be undone.
Path FaultyFileSystem::keep_copy(const Path& path) {
  const Path copy = scratch_ / std::to_string(copies_++);
  std::filesystem::create_hard_link(path, copy);
  return copy;
}

void FaultyFileSystem::append(storage::WritableFile& file, const Path& path,
                              std::span<const std::byte> bytes) {
  unsynced_from_.emplace(inode_of(path), real_.size_bytes(path));
  try {
    count_operation();
  } catch (const StorageError&) {
    file.append(bytes.first(bytes.size() / 2));
    throw;
  }
  file.append(bytes);
}

void FaultyFileSystem::sync(storage::WritableFile& file, const Path& path) {
  count_operation();
  file.sync();
  unsynced_from_.erase(inode_of(path));
}

void FaultyFileSystem::lose_unsynced(const Path& directory) {
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const auto unsynced = unsynced_from_.find(inode_of(entry.path()));
    if (unsynced != unsynced_from_.end())
      std::filesystem::resize_file(entry.path(), unsynced->second);
  }
  for (auto undo = undo_.rbegin(); undo != undo_.rend(); ++undo) undo->action();
  undo_.clear();
}

std::unique_ptr<storage::WritableFile> FaultyFileSystem::create(const Path& path) {
  count_operation();
  if (!real_.exists(path)) remember(path, [this, path] { real_.remove(path); });
  return std::make_unique<CountedFile>(*this, real_.create(path), path);
}

void FaultyFileSystem::rename(const Path& from, const Path& to) {
  count_operation();
  const Path replaced = real_.exists(to) ? keep_copy(to) : Path();
  remember(to, [this, from, to, replaced] {
    real_.rename(to, from);
    if (!replaced.empty()) real_.rename(replaced, to);
  });
  real_.rename(from, to);
}

void FaultyFileSystem::remove(const Path& path) {
  if (!real_.exists(path)) return;
  count_operation();
  const Path removed = keep_copy(path);
  remember(path, [this, removed, path] { real_.rename(removed, path); });
  real_.remove(path);
}

void FaultyFileSystem::sync_directory(const Path& path) {
  count_operation();
  real_.sync_directory(path);
  std::erase_if(undo_, [&](const Undo& undo) { return undo.directory == path; });
}

void FaultyFileSystem::sync_file(const Path& path) {
  count_operation();
  real_.sync_file(path);
}
void FaultyFileSystem::create_directory(const Path& path) {
  count_operation();
  real_.create_directory(path);
}
std::unique_ptr<storage::ReadableFile> FaultyFileSystem::open(const Path& path) {
  return real_.open(path);
}
std::uint64_t FaultyFileSystem::size_bytes(const Path& path) {
  return real_.size_bytes(path);
}
bool FaultyFileSystem::exists(const Path& path) {
  return real_.exists(path);
}
std::vector<std::string> FaultyFileSystem::list(const Path& directory) {
  return real_.list(directory);
}

}  // namespace granary::testing
