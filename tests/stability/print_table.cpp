// Prints the table of tests/README.md: every hard case, what it must do, what it did, CPU seconds.
// With arguments: only the cases whose names contain one of them.
#include <cstdio>

#include "tests/stability/hard_case.h"

using namespace granary::stability;

namespace {

bool is_wanted(const std::string& name, int count, char** words) {
  for (int k = 1; k < count; ++k)
    if (name.find(words[k]) != std::string::npos) return true;
  return count == 1;
}

}  // namespace

int main(int count, char** words) {
  double total_s = 0;
  int failed = 0;
  std::printf(
      "| case | must end | ended | ledger remainder | CPU s | diagnosis |\n"
      "| --- | --- | --- | --- | --- | --- |\n");
  for (const HardCase& hard_case : hard_cases()) {
    if (!is_wanted(hard_case.name, count, words)) continue;
    const CaseOutcome outcome = run_case(hard_case);
    const bool ran = outcome.result.has_ledger();
    char remainder[32] = "";
    if (ran)
      std::snprintf(remainder, sizeof remainder, "%.1e", outcome.result.ledger().remainder_ratio());
    std::printf("| %s | %s | %s | %s | %.2f | %s |\n", hard_case.name.c_str(),
                to_string(hard_case.end).c_str(),
                outcome.failed ? "FAILED" : to_string(outcome.end).c_str(), remainder,
                outcome.seconds, outcome.message.c_str());
    std::fflush(stdout);
    total_s += outcome.seconds;
    failed += outcome.failed || outcome.end != hard_case.end;
  }
  std::fprintf(stderr, "%.1f s, %d not as said\n", total_s, failed);
  return failed == 0 ? 0 : 1;
}
