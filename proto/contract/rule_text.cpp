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

std::string number(double value) {
  return with_digits(6, value);
}
std::string rounded(double value) {
  return with_digits(4, value);
}

}  // namespace granary
