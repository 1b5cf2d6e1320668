// SHA-256 of a file's content, as lower-case hex.
#pragma once

#include <filesystem>
#include <string>

#include "proto/contract/result.h"

namespace granary::session {

// NOT_FOUND when it cannot be opened.
Result<std::string> sha256_of_file(const std::filesystem::path& path);

}  // namespace granary::session
