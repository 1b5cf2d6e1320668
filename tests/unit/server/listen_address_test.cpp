#include "server/ops/listen_address.h"

#include <gtest/gtest.h>

namespace granary::server {

TEST(ListenAddress, this_machine_only_without_tls_and_token) {
  for (const char* good :
       {"unix:/run/granary.sock", "127.0.0.1:7420", "localhost:0", "[::1]:7420", "127.1.2.3:1"})
    EXPECT_TRUE(check_listen_address(good, false).ok()) << good;
  for (const char* bad :
       {"0.0.0.0:7420", "[::]:7420", "10.0.0.1:7420", "example.org:7420", "1270.0.0.1:5"})
    EXPECT_EQ(check_listen_address(bad, false).error().code, ErrorCode::failed_precondition) << bad;
}

TEST(ListenAddress, any_machine_with_tls_and_tokens) {
  EXPECT_TRUE(check_listen_address("0.0.0.0:7420", true).ok());
  EXPECT_FALSE(check_listen_address("0.0.0.0:http", true).ok());
}

TEST(ListenAddress, malformed_addresses_are_refused) {
  for (const char* bad : {"", "127.0.0.1", "127.0.0.1:", "127.0.0.1:http", "127.0.0.1:70000"})
    EXPECT_FALSE(check_listen_address(bad, false).ok()) << bad;
  EXPECT_FALSE(check_listen_address("unix:/" + std::string(200, 'a'), false).ok());
}

}  // namespace granary::server
