#include "worker/core/energy_ledger.h"

#include <gtest/gtest.h>

namespace granary::core {

TEST(EnergyLedger, closes_when_channels_explain_the_change) {
  EnergyLedger ledger;
  ledger.stored_at_start_j = 10;
  ledger.kinetic_j = 4;
  ledger.elastic_j = 1;
  ledger[EnergyChannel::friction] = 7;
  ledger[EnergyChannel::wall_work] = -2;
  ledger.throughput_j = 9;
  EXPECT_DOUBLE_EQ(ledger.remainder_j(), 0);
  ledger.kinetic_j += 0.9;
  EXPECT_NEAR(ledger.remainder_ratio(), 0.1, 1e-12);
}

TEST(EnergyLedger, names_every_channel) {
  for (std::size_t i = 0; i < kEnergyChannelCount; ++i)
    EXPECT_FALSE(to_string(static_cast<EnergyChannel>(i)).empty());
}

}  // namespace granary::core
