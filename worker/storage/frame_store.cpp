#include "worker/storage/frame_store.h"

#include <algorithm>

#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

constexpr std::string_view kPrefix = "segment-";

bool is_listed(const std::vector<SegmentInfo>& segments, const std::string& name) {
  return std::any_of(segments.begin(), segments.end(),
                     [&](const SegmentInfo& info) { return info.name == name; });
}

}  // namespace

FrameStore::FrameStore(FileSystem& files, Path directory, RunIdentity identity)
    : files_(files), directory_(std::move(directory)), identity_(std::move(identity)) {}

std::uint32_t FrameStore::next_index() const {
  return sealed_.empty() ? 0 : sealed_.back().index + 1;
}

void FrameStore::append(const FrameView& frame) {
  if (!writer_) writer_.emplace(files_, directory_, identity_, next_index(), frame.index);
  writer_->append(frame);
}

const std::vector<SegmentInfo>& FrameStore::seal() {
  if (writer_) {
    sealed_.push_back(std::move(*writer_).seal());
    writer_.reset();
    files_.sync_directory(directory_);
  }
  return sealed_;
}

void FrameStore::restore(std::vector<SegmentInfo> segments) {
  for (const SegmentInfo& info : segments)
    if (!is_intact(files_, directory_, info))
      throw StorageError(StorageFault::damaged, (directory_ / info.name).string() +
                                                    " is missing or its checksum is wrong");
  writer_.reset();
  sealed_ = std::move(segments);
  for (const std::string& name : files_.list(directory_))
    if (name.starts_with(kPrefix) && !is_listed(sealed_, name)) files_.remove(directory_ / name);
}

void FrameStore::clear() { restore({}); }

void FrameStore::visit_segment(const std::string& name, const FrameVisitor& visit) {
  SegmentReader reader(files_, directory_ / name, identity_);
  while (const auto frame = reader.next()) visit(*frame);
  if (reader.torn())
    throw StorageError(StorageFault::damaged, (directory_ / name).string() + ": torn frame record");
}

void FrameStore::for_each(const FrameVisitor& visit) {
  for (const SegmentInfo& info : sealed_) visit_segment(info.name, visit);
  if (writer_) visit_segment(open_segment_name(next_index()), visit);
}

std::uint64_t salvage_frames(FileSystem& files, const Path& directory, const RunIdentity& identity,
                             const FrameVisitor& visit) {
  std::uint64_t frame_count = 0;
  for (const std::string& name : files.list(directory)) {
    if (!name.starts_with(kPrefix)) continue;
    try {
      SegmentReader reader(files, directory / name, identity);
      for (; const auto frame = reader.next(); ++frame_count) visit(*frame);
    } catch (const StorageError& error) {
      if (error.fault() != StorageFault::damaged) throw;  // a header that never got written
    }
  }
  return frame_count;
}

}  // namespace granary::storage
