#include "worker/storage/frame_store.h"

#include <algorithm>
#include <iterator>

#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

bool is_listed(const std::vector<SegmentInfo>& segments, const std::string& name) {
  return std::any_of(segments.begin(), segments.end(),
                     [&](const SegmentInfo& info) { return info.name == name; });
}

}  // namespace

bool is_segment_name(const std::string& name) {
  return name.starts_with("segment-");
}

FrameStore::FrameStore(FileSystem& files, Path directory, RunIdentity identity,
                       std::string scene_text)
    : files_(files),
      directory_(std::move(directory)),
      identity_(std::move(identity)),
      scene_text_(std::move(scene_text)) {}

std::uint32_t FrameStore::next_index() const {
  return sealed_.empty() ? 0 : sealed_.back().index + 1;
}

void FrameStore::append(const FrameView& frame) {
  if (!writer_)
    writer_.emplace(files_, directory_,
                    SegmentAbout{next_index(), frame.index, identity_, scene_text_});
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
    if (is_segment_name(name) && !is_listed(sealed_, name)) files_.remove(directory_ / name);
}

void FrameStore::clear() {
  restore({});
}

void FrameStore::drop_from(std::uint64_t frame_index) {
  std::vector<Frame> kept;  // of segments that go further
  const auto take_back = [&](const std::string& name) {
    std::vector<Frame> earlier;
    visit_segment(name, [&](const Frame& frame) {
      if (frame.index < frame_index) earlier.push_back(frame);
    });
    kept.insert(kept.begin(), std::make_move_iterator(earlier.begin()),
                std::make_move_iterator(earlier.end()));
    files_.remove(directory_ / name);
  };
  if (writer_) {
    take_back(open_segment_name(next_index()));
    writer_.reset();
  }
  while (!sealed_.empty() &&
         sealed_.back().first_frame + sealed_.back().frame_count > frame_index) {
    const std::string name = sealed_.back().name;
    take_back(name);
    sealed_.pop_back();
  }
  for (const Frame& frame : kept) {
    std::vector<core::ColumnView> columns;
    for (const core::Column& column : frame.columns) columns.push_back(core::view_of(column));
    append({frame.index, frame.time_s, frame.phase, columns});
  }
}

void FrameStore::visit_segment(const std::string& name, const FrameVisitor& visit) {
  SegmentReader reader(files_, directory_ / name);
  if (reader.about().identity != identity_)
    throw StorageError(StorageFault::foreign, (directory_ / name).string() + " is of another run");
  while (const auto frame = reader.next()) visit(*frame);
  if (reader.torn())
    throw StorageError(StorageFault::damaged, (directory_ / name).string() + ": torn frame record");
}

void FrameStore::for_each(const FrameVisitor& visit) {
  for (const SegmentInfo& info : sealed_) visit_segment(info.name, visit);
  if (writer_) visit_segment(open_segment_name(next_index()), visit);
}

}  // namespace granary::storage
