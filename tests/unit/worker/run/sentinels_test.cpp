#include "worker/run/sentinels.h"

#include <gtest/gtest.h>

#include <cmath>

namespace granary::run {
namespace {

core::ColumnView view(const std::vector<double>& values, std::size_t width) {
  return {"velocity_m_per_s",    "m/s", core::ElementType::f64,
          values.size() / width, width, values.data()};
}

TEST(Sentinels, find_the_particle_that_is_no_number) {
  std::vector<double> values(12, 1.0);
  const auto columns = [&] { return std::vector{view(values, 3)}; };
  EXPECT_FALSE(find_non_finite(columns()));
  values[7] = std::nan("");
  const auto found = find_non_finite(columns());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->row, 2);
  EXPECT_EQ(found->column, "velocity_m_per_s");
  values[7] = INFINITY;
  EXPECT_TRUE(find_non_finite(columns()));
}

TEST(Sentinels, withhold_values_that_are_no_numbers) {
  std::vector<core::ObservedValue> values = {{"f1_m", "m", std::nan(""), 0.1, ""},
                                             {"f2_m", "m", 1.0, INFINITY, ""},
                                             {"f3_percent", "%", 2.0, 0.5, "fine"},
                                             {"f4_m", "m", {}, {}, "nothing landed"}};
  const auto warnings = withhold_non_finite(values);
  EXPECT_EQ(warnings.size(), 2u);
  EXPECT_FALSE(values[0].value);
  EXPECT_FALSE(values[0].error);
  EXPECT_NE(values[0].error_basis, "");
  EXPECT_EQ(values[1].value, 1.0);
  EXPECT_FALSE(values[1].error);
  EXPECT_EQ(values[2].error, 0.5);
  EXPECT_EQ(values[3].error_basis, "nothing landed");
}

TEST(Sentinels, notice_any_energy_that_is_no_number) {
  core::EnergyLedger ledger;
  EXPECT_TRUE(ledger_is_finite(ledger));
  ledger[core::EnergyChannel::friction] = std::nan("");
  EXPECT_FALSE(ledger_is_finite(ledger));
}

TEST(Sentinels, describe_when_why_who_and_what_to_change) {
  const std::string text = describe({1.25, "overlap of 0.6 R", {4, 9}, "halve time_step_s"});
  EXPECT_EQ(text,
            "unstable at t = 1.25 s: overlap of 0.6 R (particle 4, 9); try: halve time_step_s");
  EXPECT_EQ(describe({0, "x", {1, 2, 3, 4, 5, 6, 7}, ""}),
            "unstable at t = 0 s: x (particle 1, 2, 3, 4, 5, ...)");
}

}  // namespace
}  // namespace granary::run
