#include "worker/storage/salvage.h"

#include <optional>

#include "worker/storage/frame_store.h"
#include "worker/storage/result_writer.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

// Segments are in order by name; one with a torn beginning holds nothing.
std::optional<SegmentReader> open_segment(FileSystem& files, const Path& path) {
  try {
    return SegmentReader(files, path);
  } catch (const StorageError& error) {
    if (error.fault() == StorageFault::damaged) return std::nullopt;
    throw;
  }
}

ResultContent content_of(const SegmentAbout& about, std::uint64_t frame_count) {
  ResultContent content;
  content.state = "partial";
  content.message = "salvaged from an unfinished run: " + std::to_string(frame_count) + " frames";
  content.scene_text = about.scene_text;
  content.provenance.scene_key = about.identity.scene_key;
  content.provenance.engine_version = about.identity.engine_version;
  content.provenance.vector_path = about.identity.vector_path;
  return content;
}

}  // namespace

std::uint64_t salvage_run(FileSystem& files, const Path& directory, const Path& result_path) {
  ResultWriter writer(files, result_path);
  std::optional<SegmentAbout> about;
  std::uint64_t frame_count = 0;
  for (const std::string& name : files.list(directory)) {
    if (!is_segment_name(name)) continue;
    auto segment = open_segment(files, directory / name);
    if (!segment) continue;
    if (!about) about = segment->about();
    if (segment->about().identity != about->identity) continue;
    for (; const auto frame = segment->next(); ++frame_count) writer.add_frame(*frame);
  }
  if (!about)
    throw StorageError(StorageFault::missing, directory.string() + " holds no intact segment");
  writer.add_content(content_of(*about, frame_count));
  writer.commit();
  return frame_count;
}

}  // namespace granary::storage
