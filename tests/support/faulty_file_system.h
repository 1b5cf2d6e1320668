// The real file system with a fault at a chosen operation: a disk that is full, or a machine that
// stops. Of a write in progress half arrives: a torn write. lose_unsynced() then throws away
// everything that was not made durable: bytes behind the last sync of a file, and creations,
// renames and removals in directories that were not synced since. Without that call all of it
// survives.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "worker/storage/file_system.h"

namespace granary::testing {

class FaultyFileSystem : public storage::FileSystem {
 public:
  enum class Fault { none, disk_full, power_cut };

  // The fault strikes at mutating operation number `at` (from 0); all later ones fail too.
  // `scratch` is a directory on the same disk for what may have to be brought back.
  FaultyFileSystem(Fault fault, std::uint64_t at, storage::Path scratch);

  std::uint64_t operation_count() const { return operations_; }
  bool struck() const { return fault_ != Fault::none && operations_ > at_; }
  void lose_unsynced(const storage::Path& directory);

  std::unique_ptr<storage::WritableFile> create(const storage::Path& path) override;
  std::unique_ptr<storage::ReadableFile> open(const storage::Path& path) override;
  std::uint64_t size_bytes(const storage::Path& path) override;
  bool exists(const storage::Path& path) override;
  std::vector<std::string> list(const storage::Path& directory) override;
  void create_directory(const storage::Path& path) override;
  void rename(const storage::Path& from, const storage::Path& to) override;
  void remove(const storage::Path& path) override;
  void sync_file(const storage::Path& path) override;
  void sync_directory(const storage::Path& path) override;

  // For the files it hands out.
  void append(storage::WritableFile& file, const storage::Path& path,
              std::span<const std::byte> bytes);
  void sync(storage::WritableFile& file, const storage::Path& path);

 private:
  struct Undo {
    storage::Path directory;
    std::function<void()> action;
  };

  void count_operation();
  void remember(const storage::Path& path, std::function<void()> undo);
  storage::Path keep_copy(const storage::Path& path);

  storage::FileSystem& real_ = storage::real_file_system();
  Fault fault_;
  std::uint64_t at_;
  storage::Path scratch_;
  std::uint64_t operations_ = 0;
  std::uint64_t copies_ = 0;
  std::map<std::string, std::uint64_t> unsynced_from_;  // inode of a file -> durable bytes
  std::vector<Undo> undo_;
};

}  // namespace granary::testing
