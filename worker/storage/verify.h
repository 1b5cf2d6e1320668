// Is this result file whole? Opens it and walks through it: every dataset has units and the
// checksum of its bytes as written, no value, energy or frame holds a NaN or an infinity, nothing
// was added or lost.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/storage/file_system.h"

namespace granary::storage {

struct VerifyReport {
  std::vector<std::string> problems;  // one line each, with the path inside the file
  std::uint64_t dataset_count = 0;
  std::uint64_t frame_count = 0;
  std::uint64_t data_bytes = 0;
  bool ok() const { return problems.empty(); }
};

// Never throws on a bad file: that it is bad is the answer.
VerifyReport verify_result(const Path& path);

}  // namespace granary::storage
