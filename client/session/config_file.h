// The config file: the part of TOML that settings need. One `key = value` a line, values bare or in
// double quotes, comments from '#'.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "proto/contract/result.h"

namespace granary::session {

struct ConfigEntry {
  std::string value;
  int line = 0;  // 1-based
};

// Errors read "FILE:LINE: what". Keys are not judged here; a key given twice is an error.
Result<std::map<std::string, ConfigEntry>> parse_config(std::string_view text,
                                                        std::string_view file_name);

}  // namespace granary::session
