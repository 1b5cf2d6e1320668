#include "worker/storage/segment.h"

#include <array>
#include <cstdio>

#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

constexpr std::array<char, 8> kMagic = {'G', 'R', 'N', 'S', 'E', 'G', '1', '\n'};
constexpr std::uint32_t kRecordMagic = 0x4d415246;  // "FRAM"
constexpr std::size_t kHeaderBytes = 40;
constexpr std::size_t kRecordHeaderBytes = 24;
constexpr std::size_t kReadBufferBytes = 1 << 20;

std::uint64_t identity_hash(const RunIdentity& identity) {
  const std::string text = identity.text();
  return xxh3(std::as_bytes(std::span(text)));
}

Bytes encode_header(const SegmentInfo& info, const RunIdentity& identity) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.put_bytes(std::as_bytes(std::span(kMagic)));
  writer.put(info.index);
  writer.put(std::uint32_t{0});
  writer.put(info.first_frame);
  writer.put(identity_hash(identity));
  writer.put(xxh3(bytes));
  return bytes;
}

void check_header(std::span<const std::byte> bytes, const Path& path, const RunIdentity& identity) {
  ByteReader reader(bytes);
  const auto protected_bytes = bytes.first(kHeaderBytes - sizeof(std::uint64_t));
  const auto magic = reader.take(kMagic.size());
  reader.take(2 * sizeof(std::uint32_t) + sizeof(std::uint64_t));
  const auto hash = reader.get<std::uint64_t>();
  if (std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0 ||
      reader.get<std::uint64_t>() != xxh3(protected_bytes))
    throw StorageError(StorageFault::damaged, path.string() + " is no intact segment");
  if (hash != identity_hash(identity))
    throw StorageError(StorageFault::foreign, path.string() + " belongs to another run");
}

Frame decode_frame(std::span<const std::byte> payload) {
  ByteReader reader(payload);
  Frame frame;
  frame.index = reader.get<std::uint64_t>();
  frame.time_s = reader.get<double>();
  frame.phase = reader.get_text();
  frame.columns = decode_columns(reader);
  return frame;
}

std::string numbered_name(std::uint32_t segment_index, const char* suffix) {
  char name[40];
  std::snprintf(name, sizeof name, "segment-%06u%s", segment_index, suffix);
  return name;
}

}  // namespace

std::string segment_name(std::uint32_t segment_index) { return numbered_name(segment_index, ""); }
std::string open_segment_name(std::uint32_t segment_index) {
  return numbered_name(segment_index, ".open");
}

SegmentWriter::SegmentWriter(FileSystem& files, Path directory, const RunIdentity& identity,
                             std::uint32_t segment_index, std::uint64_t first_frame)
    : files_(files), directory_(std::move(directory)) {
  info_.name = segment_name(segment_index);
  info_.index = segment_index;
  info_.first_frame = first_frame;
  file_ = files_.create(directory_ / open_segment_name(segment_index));
  write(encode_header(info_, identity));
}

void SegmentWriter::write(std::span<const std::byte> bytes) {
  file_->append(bytes);
  checksum_.add(bytes);
  info_.size_bytes += bytes.size();
}

void SegmentWriter::append(const FrameView& frame) {
  buffer_.assign(kRecordHeaderBytes, std::byte{0});
  ByteWriter payload(buffer_);
  payload.put(frame.index);
  payload.put(frame.time_s);
  payload.put_text(frame.phase);
  encode_columns(buffer_, frame.columns);

  const auto body = std::span<const std::byte>(buffer_).subspan(kRecordHeaderBytes);
  Bytes header;
  ByteWriter writer(header);
  writer.put(kRecordMagic);
  writer.put(std::uint32_t{0});
  writer.put(static_cast<std::uint64_t>(body.size()));
  writer.put(xxh3(body));
  std::memcpy(buffer_.data(), header.data(), kRecordHeaderBytes);
  write(buffer_);
  ++info_.frame_count;
}

SegmentInfo SegmentWriter::seal() && {
  file_->sync();
  file_.reset();
  files_.rename(directory_ / open_segment_name(info_.index), directory_ / info_.name);
  info_.checksum = checksum_.value();
  return info_;
}

SegmentReader::SegmentReader(FileSystem& files, const Path& path, const RunIdentity& identity)
    : file_(files.open(path)), bytes_left_(files.size_bytes(path)) {
  Bytes header(kHeaderBytes);
  if (file_->read(header) != kHeaderBytes)
    throw StorageError(StorageFault::damaged, path.string() + " is no intact segment");
  check_header(header, path, identity);
  bytes_left_ -= kHeaderBytes;
}

std::optional<Frame> SegmentReader::next() {
  if (bytes_left_ == 0 || torn_) return std::nullopt;
  torn_ = true;  // until the record has proved intact
  Bytes header(kRecordHeaderBytes);
  if (file_->read(header) != kRecordHeaderBytes) return std::nullopt;
  bytes_left_ -= kRecordHeaderBytes;
  ByteReader reader(header);
  const auto magic = reader.get<std::uint32_t>();
  reader.get<std::uint32_t>();
  const auto payload_bytes = reader.get<std::uint64_t>();
  const auto checksum = reader.get<std::uint64_t>();
  if (magic != kRecordMagic || payload_bytes > bytes_left_) return std::nullopt;
  payload_.resize(payload_bytes);
  if (file_->read(payload_) != payload_bytes || xxh3(payload_) != checksum) return std::nullopt;
  bytes_left_ -= payload_bytes;
  torn_ = false;
  return decode_frame(payload_);
}

bool is_intact(FileSystem& files, const Path& directory, const SegmentInfo& info) {
  const Path path = directory / info.name;
  if (!files.exists(path) || files.size_bytes(path) != info.size_bytes) return false;
  RunningChecksum checksum;
  Bytes buffer(kReadBufferBytes);
  const auto file = files.open(path);
  while (const std::size_t got = file->read(buffer))
    checksum.add(std::span<const std::byte>(buffer).first(got));
  return checksum.value() == info.checksum;
}

}  // namespace granary::storage
