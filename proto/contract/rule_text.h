// The words of a refusal: one line that names the field, its value and the range.
#pragma once

#include <string>

#include "proto/contract/result.h"

namespace granary {

// Names and values of a scene may hold anything: control characters become '?'.
std::string one_line(std::string text);

Error refuse(const std::string& path, const std::string& what);

// Six significant digits, enough to tell a value from its limit.
std::string number(double value);
// Four, for limits that were computed.
std::string rounded(double value);

}  // namespace granary
