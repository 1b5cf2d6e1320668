#include "worker/storage/checkpoint.h"

#include <algorithm>
#include <array>

#include "worker/storage/checksum.h"
#include "worker/storage/column_codec.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

constexpr std::array<char, 8> kMagic = {'G', 'R', 'N', 'C', 'K', 'P', '1', '\n'};
constexpr const char* kNewest = "checkpoint";
constexpr const char* kPrevious = "checkpoint.previous";

constexpr std::uint32_t tag(const char (&text)[5]) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = (value << 8) | static_cast<unsigned char>(text[i]);
  return value;
}

// `fill` appends the payload in place: an engine's snapshot can be large, a second copy is not
// made.
template <typename Fill>
void put_section(Bytes& out, std::uint32_t section_tag, Fill&& fill) {
  ByteWriter writer(out);
  writer.put(section_tag);
  writer.put(std::uint32_t{0});
  const std::size_t length_at = out.size();
  writer.put(std::uint64_t{0});
  fill(out);
  const std::uint64_t payload_bytes = out.size() - length_at - sizeof(std::uint64_t);
  std::memcpy(out.data() + length_at, &payload_bytes, sizeof payload_bytes);
}

ByteReader take_section(ByteReader& in, std::uint32_t section_tag) {
  if (in.get<std::uint32_t>() != section_tag)
    throw StorageError(StorageFault::damaged, "checkpoint: unexpected section");
  in.get<std::uint32_t>();
  return ByteReader(in.take(in.get<std::uint64_t>()));
}

void encode_identity(Bytes& out, const RunIdentity& identity) {
  ByteWriter writer(out);
  writer.put_text(identity.scene_key);
  writer.put_text(identity.engine_version);
  writer.put_text(identity.vector_path);
}

RunIdentity decode_identity(ByteReader in) {
  RunIdentity identity;
  identity.scene_key = in.get_text();
  identity.engine_version = in.get_text();
  identity.vector_path = in.get_text();
  return identity;
}

void encode_segments(Bytes& out, const std::vector<SegmentInfo>& segments) {
  ByteWriter writer(out);
  writer.put(static_cast<std::uint32_t>(segments.size()));
  for (const SegmentInfo& info : segments) {
    writer.put_text(info.name);
    writer.put(info.index);
    writer.put(info.first_frame);
    writer.put(info.frame_count);
    writer.put(info.size_bytes);
    writer.put(info.checksum);
  }
}

std::vector<SegmentInfo> decode_segments(ByteReader in) {
  std::vector<SegmentInfo> segments;
  const auto count = in.get<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    SegmentInfo& info = segments.emplace_back();
    info.name = in.get_text();
    info.index = in.get<std::uint32_t>();
    info.first_frame = in.get<std::uint64_t>();
    info.frame_count = in.get<std::uint64_t>();
    info.size_bytes = in.get<std::uint64_t>();
    info.checksum = in.get<std::uint64_t>();
  }
  return segments;
}

constexpr std::size_t kChecksumSectionBytes = 24;

Bytes checksum_section(std::span<const std::byte> body) {
  Bytes section;
  put_section(section, tag("CSUM"), [&](Bytes& out) { ByteWriter(out).put(xxh3(body)); });
  return section;
}

Bytes encode(const Checkpoint& checkpoint) {
  Bytes bytes;
  ByteWriter(bytes).put_bytes(std::as_bytes(std::span(kMagic)));
  put_section(bytes, tag("IDEN"), [&](Bytes& out) { encode_identity(out, checkpoint.identity); });
  put_section(bytes, tag("SEGM"), [&](Bytes& out) { encode_segments(out, checkpoint.segments); });
  put_section(bytes, tag("RUNS"), [&](Bytes& out) { ByteWriter(out).put_bytes(checkpoint.run); });
  put_section(bytes, tag("ENGI"), [&](Bytes& out) { encode_state(out, checkpoint.engine); });
  const Bytes checksum = checksum_section(bytes);
  ByteWriter(bytes).put_bytes(checksum);
  return bytes;
}

// The body without the checksum section, once the checksum has proved right.
std::span<const std::byte> checked_body(const Bytes& bytes, const Path& path) {
  const auto damaged = StorageError(StorageFault::damaged, path.string() + ": checksum is wrong");
  if (bytes.size() < kMagic.size() + kChecksumSectionBytes) throw damaged;
  const std::span<const std::byte> all(bytes);
  const auto body = all.first(bytes.size() - kChecksumSectionBytes);
  const Bytes expected = checksum_section(body);
  if (!std::equal(expected.begin(), expected.end(), all.last(kChecksumSectionBytes).begin()))
    throw damaged;
  if (std::memcmp(body.data(), kMagic.data(), kMagic.size()) != 0) throw damaged;
  return body.subspan(kMagic.size());
}

Bytes read_all(FileSystem& files, const Path& path) {
  Bytes bytes(files.size_bytes(path));
  bytes.resize(files.open(path)->read(bytes));
  return bytes;
}

}  // namespace

void write_checkpoint_file(FileSystem& files, const Path& path, const Checkpoint& checkpoint) {
  write_atomically(files, path, encode(checkpoint));
}

Checkpoint read_checkpoint_file(FileSystem& files, const Path& path, const RunIdentity& identity) {
  const Bytes bytes = read_all(files, path);
  ByteReader in(checked_body(bytes, path));
  Checkpoint checkpoint;
  checkpoint.identity = decode_identity(take_section(in, tag("IDEN")));
  if (checkpoint.identity != identity)
    throw StorageError(StorageFault::foreign,
                       path.string() + " belongs to another scene, engine version or vector path");
  checkpoint.segments = decode_segments(take_section(in, tag("SEGM")));
  checkpoint.run = take_section(in, tag("RUNS")).rest();
  ByteReader engine = take_section(in, tag("ENGI"));
  checkpoint.engine.columns = decode_columns(engine);
  return checkpoint;
}

void save_checkpoint(FileSystem& files, const Path& directory, const Checkpoint& checkpoint) {
  const Path newest = directory / kNewest;
  const Path fresh = directory / "checkpoint.new";
  write_checkpoint_file(files, fresh, checkpoint);
  if (files.exists(newest)) files.rename(newest, directory / kPrevious);
  files.rename(fresh, newest);
  files.sync_directory(directory);
}

std::optional<Checkpoint> load_checkpoint(FileSystem& files, const Path& directory,
                                          const RunIdentity& identity,
                                          const std::function<void(const Checkpoint&)>& accept,
                                          const std::function<void(const std::string&)>& report) {
  for (const char* name : {kNewest, kPrevious}) {
    if (!files.exists(directory / name)) continue;
    try {
      Checkpoint checkpoint = read_checkpoint_file(files, directory / name, identity);
      accept(checkpoint);
      return checkpoint;
    } catch (const StorageError& error) {
      report(error.what());
    }
  }
  return std::nullopt;
}

void remove_checkpoints(FileSystem& files, const Path& directory) {
  for (const char* name : {kNewest, kPrevious, "checkpoint.new", "checkpoint.new.tmp"})
    files.remove(directory / name);
}

}  // namespace granary::storage
