// The thin seam between storage and the disk: only what durable, atomic files need, so that tests
// can inject a full disk, a torn write or a power cut at any single operation. Every failure is a
// StorageError. HDF5 does its own writes below this seam; its file is synced and renamed through
// it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace granary::storage {

using Path = std::filesystem::path;

class WritableFile {
 public:
  virtual ~WritableFile() = default;
  virtual void append(std::span<const std::byte> bytes) = 0;  // all of them or StorageError
  virtual void sync() = 0;                                    // durable when it returns
};

class ReadableFile {
 public:
  virtual ~ReadableFile() = default;
  // Fills `bytes` from the current position; returns how many there were (less only at the end).
  virtual std::size_t read(std::span<std::byte> bytes) = 0;
};

class FileSystem {
 public:
  virtual ~FileSystem() = default;
  virtual std::unique_ptr<WritableFile> create(const Path& path) = 0;  // empties an existing file
  virtual std::unique_ptr<ReadableFile> open(const Path& path) = 0;    // StorageFault::missing
  virtual std::uint64_t size_bytes(const Path& path) = 0;
  virtual bool exists(const Path& path) = 0;
  virtual std::vector<std::string> list(const Path& directory) = 0;  // names, sorted
  virtual void create_directory(const Path& path) = 0;               // with parents
  virtual void rename(const Path& from, const Path& to) = 0;         // replaces `to` atomically
  virtual void remove(const Path& path) = 0;                         // absent is fine
  virtual void sync_file(const Path& path) = 0;
  virtual void sync_directory(const Path& path) = 0;  // makes renames and removals in it durable
};

FileSystem& real_file_system();

// Writes `bytes` so that after any crash `path` holds either its old content or all of the new.
void write_atomically(FileSystem& files, const Path& path, std::span<const std::byte> bytes);

// The directory that holds `path`: never empty.
Path directory_of(const Path& path);

}  // namespace granary::storage
