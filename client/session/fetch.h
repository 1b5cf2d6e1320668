// Downloads a result file: into FILE.part, continued there after any interruption (of the stream or
// of this program), checked against the recorded SHA-256, then renamed. FILE.sha256 keeps the sum
// in the form `sha256sum -c` reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "client/session/session.h"
#include "proto/contract/result.h"

namespace granary::session {

struct FetchRequest {
  std::string job;
  std::filesystem::path file;
  bool overwrite = false;       // else an existing file with other content is an error
  bool record_checksum = true;  // FILE.sha256
};

struct Fetched {
  std::string sha256;
  std::uint64_t size_bytes = 0;
  bool was_there = false;  // the file already held this content
};

using FetchProgress = std::function<void(std::uint64_t have_bytes, std::uint64_t size_bytes)>;

// DATA_LOSS when the content does not match its checksum even from the start.
Result<Fetched> fetch_result(Session& session, const FetchRequest& request,
                             const FetchProgress& progress, Interrupt& interrupt);

}  // namespace granary::session
