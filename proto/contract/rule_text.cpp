#include "proto/contract/rule_text.h"

#include <cstdio>

namespace granary {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace granary
