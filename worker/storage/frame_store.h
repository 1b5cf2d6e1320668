// The frames of one run in its directory: sealed segments and at most one that is being written. A
// segment is sealed when a checkpoint is taken, so the checkpoint's list names exactly the frames
// that lie before it, and a resumed run drops whatever came later and computes it again.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "worker/storage/segment.h"

namespace granary::storage {

using FrameVisitor = std::function<void(const Frame&)>;

class FrameStore {
 public:
  FrameStore(FileSystem& files, Path directory, RunIdentity identity, std::string scene_text);

  void append(const FrameView& frame);
  // Seals the open segment, if any; afterwards everything appended so far is durable.
  const std::vector<SegmentInfo>& seal();
  // Goes back to the listed segments and deletes all others. StorageError(damaged) when one of
  // them is missing or its checksum is wrong.
  void restore(std::vector<SegmentInfo> segments);
  // Forgets the frames from this index on: the run has gone back. Until the next checkpoint the one
  // on disk may name a segment that is gone, and is then passed over.
  void drop_from(std::uint64_t frame_index);
  // All frames in order, the open segment's included. StorageError: damaged on a torn record,
  // foreign on a segment of another run.
  void for_each(const FrameVisitor& visit);
  // Deletes every segment in the directory.
  void clear();

 private:
  std::uint32_t next_index() const;
  void visit_segment(const std::string& name, const FrameVisitor& visit);

  FileSystem& files_;
  Path directory_;
  RunIdentity identity_;
  std::string scene_text_;
  std::vector<SegmentInfo> sealed_;
  std::optional<SegmentWriter> writer_;
};

// True for names of segments, sealed or open.
bool is_segment_name(const std::string& name);

}  // namespace granary::storage
