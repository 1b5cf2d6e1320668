#include "proto/contract/rule_text.h"

#include <cstdio>

namespace granary {

namespace {

std::string with_digits(int digits, double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

}  // namespace

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

Error refuse(const std::string& path, const std::string& what) {
  return {ErrorCode::invalid_argument, one_line(path + ": " + what), path};
}

std::string number(double value) {
  return with_digits(6, value);
}
std::string rounded(double value) {
  return with_digits(4, value);
}

}  // namespace granary
