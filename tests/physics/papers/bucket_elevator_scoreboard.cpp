// Prints the scoreboard of the bucket-elevator paper as the markdown table of README.md.
// Usage: bucket_elevator_scoreboard [fillings]
#include <cstdio>
#include <cstdlib>

#include "proto/contract/version.h"
#include "tests/physics/papers/scoreboard.h"

namespace {

const char* name_of(granary::tests::Verdict verdict) {
  switch (verdict) {
    case granary::tests::Verdict::agrees:
      return "agrees";
    case granary::tests::Verdict::agrees_spin_locked:
      return "agrees with spin locked";
    case granary::tests::Verdict::differs:
      return "**differs**";
    case granary::tests::Verdict::reported:
      break;
  }
  return "reported";
}

}  // namespace

int main(int argc, char** argv) {
  using namespace granary::tests;
  const Effort effort{.fillings = argc > 1 ? std::atoi(argv[1]) : 3, .long_runs = true};
  std::printf("Engine %s, means over %d fillings with their 95 %% intervals.\n\n",
              granary::kEngineVersion, effort.fillings);
  std::printf("| claim | ours | paper | experiment | verdict | tolerance, what is not stated |\n");
  std::printf("| --- | --- | --- | --- | --- | --- |\n");
  for (const auto group : {bead_rows, flow_rows, penalty_rows, design_rows})
    for (const Row& row : group(effort)) {
      std::printf("| %s | %s | %s | %s | %s | %s |\n", row.claim.c_str(), row.ours.c_str(),
                  row.paper.c_str(), row.experiment.c_str(), name_of(row.verdict),
                  row.note.c_str());
      std::fflush(stdout);
    }
}
