#include "client/session/backup.h"

#include "client/session/file_checksum.h"
#include "client/session/part_file.h"

namespace granary::session {
namespace {

namespace fs = std::filesystem;

// One pass; a broken one starts again with a newer copy, so there is nothing to resume.
Result<BackupMade> receive(Session& session, PartFile& part, const BackupProgress& progress) {
  BackupMade made;
  std::uint64_t have_bytes = 0;
  if (Status emptied = part.empty(); !emptied) return emptied.error();
  const Status received = session.backup([&](const v1::DownloadChunk& chunk) -> Status {
    if (chunk.has_artifact()) made = {chunk.artifact().sha256(), chunk.artifact().size_bytes()};
    Status written = part.write_at(have_bytes, chunk.data());
    have_bytes += chunk.data().size();
    progress(have_bytes, made.size_bytes);
    return written;
  });
  if (!received) return received.error();
  return made;
}

}  // namespace

Result<BackupMade> fetch_backup(Session& session, const fs::path& file, bool overwrite,
                                const BackupProgress& progress) {
  if (!overwrite && fs::exists(file))
    return Error{ErrorCode::failed_precondition, file.string() + " exists; --force replaces it", ""};
  auto part = PartFile::open(with_suffix(file, ".part"));
  if (!part) return part.error();
  auto made = receive(session, *part, progress);
  if (!made) return made.error();
  if (Status synced = part->sync(); !synced) return synced.error();
  const auto sum = sha256_of_file(part->path());
  if (!sum) return sum.error();
  if (*sum != made->sha256)
    return Error{ErrorCode::data_loss, part->path().string() + " is not what the server sent", ""};
  std::error_code failure;
  fs::rename(part->path(), file, failure);
  if (failure) return Error{ErrorCode::failed_precondition, file.string() + ": " + failure.message(), ""};
  return made;
}

}  // namespace granary::session
