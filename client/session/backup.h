// A copy of the server's database in a file here: checked against its SHA-256, synced, then renamed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "client/session/session.h"
#include "proto/contract/result.h"

namespace granary::session {

struct BackupMade {
  std::string sha256;
  std::uint64_t size_bytes = 0;
};
using BackupProgress = std::function<void(std::uint64_t have_bytes, std::uint64_t size_bytes)>;

// FAILED_PRECONDITION: the file exists and `overwrite` is false.
Result<BackupMade> fetch_backup(Session& session, const std::filesystem::path& file, bool overwrite,
                                const BackupProgress& progress);

}  // namespace granary::session
