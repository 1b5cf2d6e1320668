// A segment: frames appended to one file, each as a checksummed record that reaches the operating
// system in a single write. A killed writer therefore loses at most the frame it was writing, and a
// torn tail is recognised, never read as data.
//
//   file   := "GRNSEG1\n", record(about), record(frame) *
//   record := u32 "RECD", u32 0, u64 payload bytes, u64 XXH3 of the payload, payload
//   about  := u32 segment index, u64 first frame, text scene key, text engine version,
//             text vector path, text scene          (text = u32 length, bytes)
//   frame  := u64 frame index, f64 time [s], text phase, columns (column_codec.h)
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "worker/core/column.h"
#include "worker/storage/checksum.h"
#include "worker/storage/column_codec.h"
#include "worker/storage/file_system.h"
#include "worker/storage/run_identity.h"

namespace granary::storage {

struct FrameView {
  std::uint64_t index = 0;
  double time_s = 0;
  std::string_view phase;
  std::span<const core::ColumnView> columns;
};

struct Frame {
  std::uint64_t index = 0;
  double time_s = 0;
  std::string phase;
  std::vector<core::Column> columns;
};

// What a segment says of itself; enough to make a result file of it when all else is lost.
struct SegmentAbout {
  std::uint32_t index = 0;
  std::uint64_t first_frame = 0;
  RunIdentity identity;
  std::string scene_text;
};

// A sealed segment, as a checkpoint lists it.
struct SegmentInfo {
  std::string name;  // file name in the run's directory
  std::uint32_t index = 0;
  std::uint64_t first_frame = 0;
  std::uint64_t frame_count = 0;
  std::uint64_t size_bytes = 0;
  std::uint64_t checksum = 0;  // XXH3-64 of all record headers, which hold those of the payloads
};

class SegmentWriter {
 public:
  SegmentWriter(FileSystem& files, Path directory, const SegmentAbout& about);
  void append(const FrameView& frame);
  // Makes the segment durable under its final name (the directory is synced by the caller).
  SegmentInfo seal() &&;

 private:
  void begin_record();
  void end_record();

  FileSystem& files_;
  Path directory_;
  SegmentInfo info_;
  std::unique_ptr<WritableFile> file_;
  RunningChecksum checksum_;
  Bytes record_;  // kept: frames are of similar size
};

class SegmentReader {
 public:
  // StorageError(damaged) when the file does not even say what it is.
  SegmentReader(FileSystem& files, const Path& path);
  const SegmentAbout& about() const { return about_; }
  // The next intact frame; nullopt at the end and at the first damaged record.
  std::optional<Frame> next();
  bool skip();                         // as next(), without decoding it
  bool torn() const { return torn_; }  // stopped before the end of the file
  std::uint64_t checksum() const { return checksum_.value(); }  // of the records read so far

 private:
  bool read_record();  // into payload_; false at the end or when damaged

  std::unique_ptr<ReadableFile> file_;
  std::uint64_t bytes_left_ = 0;
  SegmentAbout about_;
  bool torn_ = false;
  RunningChecksum checksum_;
  Bytes payload_;
};

std::string segment_name(std::uint32_t segment_index);       // "segment-000003"
std::string open_segment_name(std::uint32_t segment_index);  // the same while it is written

// True when the file is there, complete and has the checksum of its listing.
bool is_intact(FileSystem& files, const Path& directory, const SegmentInfo& info);

}  // namespace granary::storage
