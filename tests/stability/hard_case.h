// Hard cases: scenes that break solvers. Each says beforehand how it must end; none may end in a
// NaN, a hang, a crash or silence. README.md of tests holds the table of what they do.
#pragma once

#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "proto/contract/scene_text.h"
#include "tests/support/meddled_simulation.h"
#include "worker/run/task.h"

namespace granary::stability {

// Largest share of the energy exchanged that a complete case may miss.
constexpr double kLargestRemainder = 1e-3;

enum class End {
  complete,   // sound physics: values, and the ledger closed
  recovered,  // complete after the run changed a setting by itself, and says so
  unstable,   // given up, with cause and advice
  refused     // before anything is queued or computed
};
std::string to_string(End end);

struct HardCase {
  std::string name;
  std::string scene;                   // text format
  std::vector<FieldSetting> settings;  // --set
  End end = End::complete;
  // Of the message (unstable, refused) or of the recovery's evidence; must be found in it.
  std::string diagnosis = {};
  std::optional<testing::Meddling> meddling = {};
  double largest_remainder = kLargestRemainder;  // of a complete case
};

// For GoogleTest, which would print the bytes of a case.
inline void PrintTo(const HardCase& hard_case, std::ostream* out) {
  *out << hard_case.name;
}

const std::vector<HardCase>& hard_cases();

struct CaseOutcome {
  End end = End::complete;
  bool failed = false;  // none of the four: error, timeout; `message` says what
  std::string message;  // diagnosis
  double seconds = 0;   // CPU
  v1::Result result;
};
CaseOutcome run_case(const HardCase& hard_case);
// Wall seconds after which a case counts as hung, without sanitizers.
constexpr double kHangSeconds = 60;

}  // namespace granary::stability
