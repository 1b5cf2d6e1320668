// Durations as people write them.
#pragma once

#include <string>
#include <string_view>

#include "proto/contract/result.h"

namespace granary::commands {

// "90", "90s", "1.5h", "10m", "1h30m" -> seconds (> 0, finite, at most a year).
Result<double> parse_duration_s(std::string_view text);

}  // namespace granary::commands
