#include "server/workers/lease_table.h"

#include <gtest/gtest.h>

namespace granary::server {

TEST(LeaseTable, expires_when_heartbeats_stop) {
  LeaseTable leases;
  leases.grant(1, 10, "a", 0);
  EXPECT_TRUE(leases.expired(kLeaseMs - 1).empty());
  EXPECT_TRUE(leases.renew(1, "a", kLeaseMs - 1));
  EXPECT_TRUE(leases.expired(2 * kLeaseMs - 2).empty());
  ASSERT_EQ(leases.expired(2 * kLeaseMs - 1).size(), 1u);
  EXPECT_EQ(leases.expired(2 * kLeaseMs - 1)[0].job, 10);
}

TEST(LeaseTable, only_the_holder_renews) {
  LeaseTable leases;
  leases.grant(1, 10, "a", 0);
  EXPECT_FALSE(leases.renew(1, "b", 5));
  EXPECT_FALSE(leases.renew(2, "a", 5));
}

TEST(LeaseTable, a_broken_stream_shortens_but_never_lengthens) {
  LeaseTable leases;
  leases.grant(1, 10, "a", 0);
  leases.grant(2, 11, "b", 0);
  leases.shorten("a", 100);
  EXPECT_EQ(leases.find(1)->expires_ms, 100 + kReconnectMs);
  EXPECT_EQ(leases.find(2)->expires_ms, kLeaseMs);
  leases.shorten("a", kLeaseMs);
  EXPECT_EQ(leases.find(1)->expires_ms, 100 + kReconnectMs);
}

TEST(LeaseTable, counts_what_each_worker_holds) {
  LeaseTable leases;
  leases.grant(1, 10, "a", 0);
  leases.grant(2, 11, "a", 0);
  leases.grant(2, 11, "b", 0);  // moved
  EXPECT_EQ(leases.count_of("a"), 1u);
  EXPECT_EQ(leases.count_of("b"), 1u);
  leases.end(1);
  leases.end(1);
  EXPECT_EQ(leases.count_of("a"), 0u);
}

}  // namespace granary::server
