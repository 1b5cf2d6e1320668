// The words of a refusal: one line that names the field, its value and the range.
#pragma once

#include <string>

#include "proto/contract/result.h"

namespace granary {

inline Error refuse(const std::string& path, const std::string& what) {
  return {ErrorCode::invalid_argument, path + ": " + what, path};
}

// Six significant digits, enough to tell a value from its limit.
std::string number(double value);
// Four, for limits that were computed.
std::string rounded(double value);

}  // namespace granary
