#include "client/session/data_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/support/program.h"

namespace granary::session {
namespace {

TEST(SocketPath, lies_in_the_data_directory_while_it_fits_into_an_address) {
  constexpr std::size_t kLongest = sizeof(sockaddr_un::sun_path) - 1;  // and a terminating zero
  const std::string name = "/granaryd.sock";
  const std::string fits = "/" + std::string(kLongest - name.size() - 1, 'x');
  EXPECT_EQ(socket_path(fits, 1000), fits + name);
  EXPECT_EQ(socket_path(fits, 1000).string().size(), kLongest);
  const auto moved = socket_path(fits + "x", 1000);
  EXPECT_THAT(moved.string(), testing::StartsWith("/tmp/granary-1000-"));
  EXPECT_LT(moved.string().size(), kLongest);
}

TEST(SocketPath, differs_by_directory_and_user) {
  const std::string a = "/" + std::string(200, 'a'), b = "/" + std::string(200, 'b');
  EXPECT_NE(socket_path(a, 1), socket_path(b, 1));
  EXPECT_NE(socket_path(a, 1), socket_path(a, 2));
  EXPECT_EQ(socket_path(a, 1), socket_path(a, 1));
}

TEST(DataDirectory, is_made_for_its_owner_alone) {
  const test::ScratchDirectory scratch;
  const auto directory = DataDirectory::open(scratch.file("a/b"));
  ASSERT_TRUE(directory.ok()) << directory.error().message;
  struct stat facts {};
  ASSERT_EQ(stat(scratch.file("a/b").c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0700u);
}

TEST(DataDirectory, remembers_where_its_server_listens) {
  const test::ScratchDirectory scratch;
  const auto directory = DataDirectory::open(scratch.path());
  ASSERT_TRUE(directory.ok());
  EXPECT_EQ(directory->server_address(), "unix:" + scratch.file("granaryd.sock"));
  ASSERT_TRUE(directory->write_server_address("127.0.0.1:7443").ok());
  EXPECT_EQ(directory->server_address(), "127.0.0.1:7443");
  directory->forget_server();
  EXPECT_EQ(directory->server_address(), "unix:" + scratch.file("granaryd.sock"));
}

TEST(DataDirectory, trusts_a_short_socket_directory_only_when_it_is_ours_alone) {
  const test::ScratchDirectory scratch;
  const std::string deep = scratch.file(std::string(120, 'd'));
  const auto directory = DataDirectory::open(deep);
  ASSERT_TRUE(directory.ok());
  const auto socket_directory = socket_path(deep, getuid()).parent_path();
  std::filesystem::create_directory(socket_directory);
  chmod(socket_directory.c_str(), 0755);  // others could have put a socket there
  EXPECT_FALSE(directory->socket_address().ok());
  chmod(socket_directory.c_str(), 0700);
  EXPECT_TRUE(directory->socket_address().ok());
  std::filesystem::remove(socket_directory);
}

}  // namespace
}  // namespace granary::session
