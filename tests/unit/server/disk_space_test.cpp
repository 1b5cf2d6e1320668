#include "server/ops/disk_space.h"

#include <gtest/gtest.h>

namespace granary::server {
namespace {

TEST(DiskSpace, intake_stops_while_running_jobs_still_have_room) {
  EXPECT_EQ(intake_refusal(1000 << 20, 200 << 20, false), "");
  EXPECT_NE(intake_refusal(199 << 20, 200 << 20, false).find("199 MB left"), std::string::npos);
}

TEST(DiskSpace, intake_starts_again_with_a_margin) {
  EXPECT_NE(intake_refusal(201 << 20, 200 << 20, true), "");
  EXPECT_EQ(intake_refusal(201 << 20, 200 << 20, false), "");
  EXPECT_EQ(intake_refusal(251 << 20, 200 << 20, true), "");
}

TEST(DiskSpace, network_file_systems_are_known_by_name) {
  EXPECT_STREQ(network_file_system(0x6969), "NFS");
  EXPECT_STREQ(network_file_system(0xFF534D42), "CIFS");
  EXPECT_EQ(network_file_system(0xEF53), nullptr) << "ext4 is local";
  EXPECT_EQ(network_file_system(0x01021994), nullptr) << "tmpfs is local";
}

TEST(DiskSpace, the_file_system_of_the_tests_is_local) {
  EXPECT_TRUE(check_local_file_system("/proc").ok());
  EXPECT_TRUE(check_local_file_system("/no/such/folder").ok()) << "left to whoever opens it";
}

}  // namespace
}  // namespace granary::server
