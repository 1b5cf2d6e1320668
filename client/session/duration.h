// Durations as people write and read them.
#pragma once

#include <string>
#include <string_view>

#include "proto/contract/result.h"

namespace granary::session {

// "90", "90s", "1.5h", "10m", "1h30m" -> seconds (> 0, finite, at most a year).
Result<double> parse_duration_s(std::string_view text);

// 12 -> "0:12", 3725 -> "1:02:05", 90000 -> "1d 1:00:00".
std::string clock_text(double duration_s);

}  // namespace granary::session
