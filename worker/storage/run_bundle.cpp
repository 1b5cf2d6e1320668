#include "worker/storage/run_bundle.h"

#include <array>
#include <memory>

#include "worker/storage/checkpoint.h"
#include "worker/storage/checksum.h"
#include "worker/storage/frame_store.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

constexpr std::array<char, 8> kMagic = {'G', 'R', 'N', 'B', 'N', 'D', '1', '\n'};
constexpr const char* kCheckpoint = "checkpoint";
constexpr std::size_t kMaxNameBytes = 64;

Bytes read_all(FileSystem& files, const Path& path) {
  Bytes bytes(files.size_bytes(path));
  bytes.resize(files.open(path)->read(bytes));
  return bytes;
}

// Segments are as large as the frames between two checkpoints: one at a time fits in memory.
void put_entry(WritableFile& out, std::string_view name, const Bytes& content) {
  Bytes header;
  ByteWriter writer(header);
  writer.put_text(name);
  writer.put(static_cast<std::uint64_t>(content.size()));
  writer.put(xxh3(content));
  out.append(header);
  out.append(content);
}

[[noreturn]] void refuse(const Path& bundle) {
  throw StorageError(StorageFault::damaged, bundle.string() + " is no intact bundle");
}

struct Entry {
  std::string name;
  Bytes content;
};

class BundleReader {
 public:
  BundleReader(FileSystem& files, const Path& bundle)
      : path_(bundle), file_(files.open(bundle)), bytes_left_(files.size_bytes(bundle)) {
    const Bytes magic = take(kMagic.size());
    if (std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0) refuse(path_);
  }

  bool at_end() const { return bytes_left_ == 0; }

  Entry next() {
    Entry entry;
    const auto name_bytes = get<std::uint32_t>();
    if (name_bytes > kMaxNameBytes) refuse(path_);
    const Bytes name = take(name_bytes);
    entry.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
    const auto byte_count = get<std::uint64_t>();
    const auto checksum = get<std::uint64_t>();
    entry.content = take(byte_count);
    if (xxh3(entry.content) != checksum) refuse(path_);
    return entry;
  }

 private:
  Bytes take(std::uint64_t byte_count) {
    if (byte_count > bytes_left_) refuse(path_);
    Bytes bytes(byte_count);
    if (file_->read(bytes) != byte_count) refuse(path_);
    bytes_left_ -= byte_count;
    return bytes;
  }
  template <typename T>
  T get() {
    const Bytes bytes = take(sizeof(T));
    return ByteReader(bytes).get<T>();
  }

  Path path_;
  std::unique_ptr<ReadableFile> file_;
  std::uint64_t bytes_left_;
};

// Names come from outside: only those that a run itself would write, and never a way out.
bool is_safe_segment_name(const std::string& name) {
  return is_segment_name(name) && name.find('/') == std::string::npos;
}

}  // namespace

void pack_run(FileSystem& files, const Path& directory, const Path& bundle) {
  const Bytes checkpoint = read_all(files, directory / kCheckpoint);
  const Path temporary = bundle.string() + ".tmp";
  {
    const auto out = files.create(temporary);
    out->append(std::as_bytes(std::span(kMagic)));
    put_entry(*out, kCheckpoint, checkpoint);
    for (const SegmentInfo& info : segments_of(checkpoint, directory / kCheckpoint))
      put_entry(*out, info.name, read_all(files, directory / info.name));
    out->sync();
  }
  files.rename(temporary, bundle);
}

void unpack_run(FileSystem& files, const Path& bundle, const Path& directory) {
  files.create_directory(directory);
  remove_checkpoints(files, directory);
  BundleReader reader(files, bundle);
  const Entry checkpoint = reader.next();
  if (checkpoint.name != kCheckpoint) refuse(bundle);
  while (!reader.at_end()) {
    const Entry segment = reader.next();
    if (!is_safe_segment_name(segment.name)) refuse(bundle);
    files.create(directory / segment.name)->append(segment.content);
  }
  // Last: a directory with a checkpoint has all that the checkpoint needs.
  write_atomically(files, directory / kCheckpoint, checkpoint.content);
}

}  // namespace granary::storage
