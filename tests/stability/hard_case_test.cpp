// Claim: every hard case ends as its list says beforehand: complete with a closed ledger, recovered
//   and saying how, unstable or refused with the right diagnosis. Never a NaN, a hang, a crash,
//   silence.
// Method: the run layer with both engines, as a worker runs them, without files.
// Reference: PHYSICS section F and the list of issue 7.
// Tolerance: remainder 1e-3 of the energy exchanged (PHYSICS section I).
// Seconds: a minute in all.
#include "tests/stability/hard_case.h"

#include <gtest/gtest.h>

#include <cmath>

namespace granary::stability {
namespace {

class HardCases : public ::testing::TestWithParam<HardCase> {};

void expect_honest_values(const v1::Result& result) {
  for (const auto& [name, quantity] : result.values()) {
    if (quantity.has_value())
      EXPECT_TRUE(std::isfinite(quantity.value())) << name;
    else
      EXPECT_FALSE(quantity.error_basis().empty()) << name << " is unknown without a reason";
  }
}

TEST_P(HardCases, ends_as_said_beforehand) {
  const HardCase& hard_case = GetParam();
  const CaseOutcome outcome = run_case(hard_case);
  ASSERT_FALSE(outcome.failed) << outcome.message;
  EXPECT_EQ(to_string(outcome.end), to_string(hard_case.end)) << outcome.message;
  EXPECT_NE(outcome.message.find(hard_case.diagnosis), std::string::npos) << outcome.message;
  expect_honest_values(outcome.result);
  switch (outcome.end) {
    case End::complete:
    case End::recovered:
      EXPECT_LT(outcome.result.ledger().remainder_ratio(), hard_case.largest_remainder);
      break;
    case End::unstable:
      EXPECT_TRUE(outcome.result.values().empty());
      EXPECT_NE(outcome.message.find("; try: "), std::string::npos) << outcome.message;
      EXPECT_TRUE(std::isfinite(outcome.result.ledger().remainder_ratio()));
      break;
    case End::refused:
      EXPECT_FALSE(outcome.message.empty());
      break;
  }
}

INSTANTIATE_TEST_SUITE_P(, HardCases, ::testing::ValuesIn(hard_cases()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace granary::stability
