#include "worker/storage/segment.h"

#include <array>
#include <cstdio>

#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

constexpr std::array<char, 8> kMagic = {'G', 'R', 'N', 'S', 'E', 'G', '1', '\n'};
constexpr std::uint32_t kRecordMagic = 0x44434552;  // "RECD"
constexpr std::size_t kRecordHeaderBytes = 24;

void encode_about(Bytes& out, const SegmentAbout& about) {
  ByteWriter writer(out);
  writer.put(about.index);
  writer.put(about.first_frame);
  writer.put_text(about.identity.scene_key);
  writer.put_text(about.identity.engine_version);
  writer.put_text(about.identity.vector_path);
  writer.put_text(about.scene_text);
}

SegmentAbout decode_about(std::span<const std::byte> payload) {
  ByteReader reader(payload);
  SegmentAbout about;
  about.index = reader.get<std::uint32_t>();
  about.first_frame = reader.get<std::uint64_t>();
  about.identity.scene_key = reader.get_text();
  about.identity.engine_version = reader.get_text();
  about.identity.vector_path = reader.get_text();
  about.scene_text = reader.get_text();
  return about;
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

std::string segment_name(std::uint32_t segment_index) {
  return numbered_name(segment_index, "");
}
std::string open_segment_name(std::uint32_t segment_index) {
  return numbered_name(segment_index, ".open");
}

SegmentWriter::SegmentWriter(FileSystem& files, Path directory, const SegmentAbout& about)
    : files_(files), directory_(std::move(directory)) {
  info_.name = segment_name(about.index);
  info_.index = about.index;
  info_.first_frame = about.first_frame;
  file_ = files_.create(directory_ / open_segment_name(about.index));
  record_.assign(reinterpret_cast<const std::byte*>(kMagic.data()),
                 reinterpret_cast<const std::byte*>(kMagic.data() + kMagic.size()));
  file_->append(record_);
  info_.size_bytes = record_.size();
  begin_record();
  encode_about(record_, about);
  end_record();
}

void SegmentWriter::begin_record() {
  record_.assign(kRecordHeaderBytes, std::byte{0});
}

// Fills in the header that begin_record() left room for, and hands everything over in one write.
void SegmentWriter::end_record() {
  const auto payload = std::span<const std::byte>(record_).subspan(kRecordHeaderBytes);
  Bytes header;
  ByteWriter writer(header);
  writer.put(kRecordMagic);
  writer.put(std::uint32_t{0});
  writer.put(static_cast<std::uint64_t>(payload.size()));
  writer.put(xxh3(payload));
  std::memcpy(record_.data(), header.data(), kRecordHeaderBytes);
  file_->append(record_);
  checksum_.add(header);
  info_.size_bytes += record_.size();
}

void SegmentWriter::append(const FrameView& frame) {
  begin_record();
  ByteWriter payload(record_);
  payload.put(frame.index);
  payload.put(frame.time_s);
  payload.put_text(frame.phase);
  encode_columns(record_, frame.columns);
  end_record();
  ++info_.frame_count;
}

SegmentInfo SegmentWriter::seal() && {
  file_->sync();
  file_.reset();
  files_.rename(directory_ / open_segment_name(info_.index), directory_ / info_.name);
  info_.checksum = checksum_.value();
  return info_;
}

SegmentReader::SegmentReader(FileSystem& files, const Path& path)
    : file_(files.open(path)), bytes_left_(files.size_bytes(path)) {
  std::array<char, kMagic.size()> magic{};
  bytes_left_ -= file_->read(std::as_writable_bytes(std::span(magic)));
  if (magic != kMagic || !read_record())
    throw StorageError(StorageFault::damaged, path.string() + " is no intact segment");
  about_ = decode_about(payload_);
}

bool SegmentReader::read_record() {
  if (bytes_left_ == 0 || torn_) return false;
  torn_ = true;  // until the record has proved intact
  Bytes header(kRecordHeaderBytes);
  if (file_->read(header) != kRecordHeaderBytes) return false;
  bytes_left_ -= kRecordHeaderBytes;
  ByteReader reader(header);
  const auto magic = reader.get<std::uint32_t>();
  reader.get<std::uint32_t>();
  const auto payload_bytes = reader.get<std::uint64_t>();
  const auto checksum = reader.get<std::uint64_t>();
  if (magic != kRecordMagic || payload_bytes > bytes_left_) return false;
  payload_.resize(payload_bytes);
  if (file_->read(payload_) != payload_bytes || xxh3(payload_) != checksum) return false;
  bytes_left_ -= payload_bytes;
  checksum_.add(header);
  torn_ = false;
  return true;
}

bool SegmentReader::skip() {
  return read_record();
}

std::optional<Frame> SegmentReader::next() {
  if (!read_record()) return std::nullopt;
  return decode_frame(payload_);
}

bool is_intact(FileSystem& files, const Path& directory, const SegmentInfo& info) {
  const Path path = directory / info.name;
  if (!files.exists(path) || files.size_bytes(path) != info.size_bytes) return false;
  try {
    SegmentReader reader(files, path);
    while (reader.skip()) {
    }
    return !reader.torn() && reader.checksum() == info.checksum;
  } catch (const StorageError& error) {
    if (error.fault() == StorageFault::damaged) return false;
    throw;
  }
}

}  // namespace granary::storage
