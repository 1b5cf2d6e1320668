// What every fuzz target asks of an answer. A broken promise aborts: that is what a fuzzer looks
// for.
#pragma once

#include <cstdio>
#include <cstdlib>

#include "proto/contract/result.h"

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

inline void require_one_line(const granary::Error& error) {
  require(!error.message.empty(), "an error says something");
  require(error.message.find('\n') == std::string::npos, "an error is one line");
}
