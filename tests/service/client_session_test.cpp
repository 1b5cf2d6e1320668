// Finding and reaching a server: absent, refusing, draining, breaking.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>

#include "tests/support/client_fixture.h"

namespace granary::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

double seconds_of(const std::function<void()>& act) {
  const auto start = std::chrono::steady_clock::now();
  act();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class ClientSession : public ClientTest {};

TEST_F(ClientSession, absent_named_server_is_exit_4_at_once) {
  for (const std::string& address :
       {"unix:" + scratch_.file("nobody.sock"), std::string("127.0.0.1:1")}) {
    environment_["GRANARY_SERVER"] = address;
    const double elapsed_s = seconds_of([&] {
      const Outputs outputs = granary({"ls"});
      EXPECT_EQ(outputs.exit_code, 4);
      EXPECT_THAT(outputs.err, IsOneErrorLine());
      EXPECT_THAT(outputs.err, HasSubstr(address));
    });
    EXPECT_LT(elapsed_s, 2) << address;
  }
}

TEST_F(ClientSession, server_that_accepts_but_never_answers_is_exit_4_within_two_seconds) {
  const std::string path = scratch_.file("deaf.sock");
  const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(listener, 5), 0);
  environment_["GRANARY_SERVER"] = "unix:" + path;
  const double elapsed_s = seconds_of([&] { EXPECT_EQ(granary({"ls"}).exit_code, 4); });
  EXPECT_LT(elapsed_s, 2.5);
  close(listener);
}

TEST_F(ClientSession, lost_replies_are_repeated) {
  jobs().add("jobs/7");
  jobs().lose_replies("Get", 3);
  EXPECT_EQ(granary({"status", "7"}).exit_code, 0);
  EXPECT_EQ(jobs().calls("Get"), 4);
}

TEST_F(ClientSession, deletion_whose_reply_was_lost_counts_as_done) {
  jobs().add("jobs/7");
  jobs().lose_replies("Delete", 1);
  EXPECT_EQ(granary({"delete", "7"}).exit_code, 0);
  EXPECT_EQ(granary({"delete", "7"}).exit_code, 3);
}

TEST_F(ClientSession, retry_whose_reply_was_lost_counts_as_done) {
  jobs().add("jobs/7", v1::ERROR);
  jobs().lose_replies("Retry", 1);
  const Outputs outputs = granary({"retry", "7"});
  EXPECT_EQ(outputs.exit_code, 0) << outputs.err;
  EXPECT_THAT(outputs.out, HasSubstr("waiting"));
  EXPECT_EQ(granary({"retry", "7"}).exit_code, 2);  // now it really is queued already
}

TEST_F(ClientSession, token_comes_from_its_file_and_a_wrong_one_is_exit_5) {
  jobs().expect_token("sesame");
  const Outputs without = granary({"ls"});
  EXPECT_EQ(without.exit_code, 5);
  EXPECT_THAT(without.err, IsOneErrorLine());
  const std::string good = scratch_.write("good", "sesame\n"), bad = scratch_.write("bad", "no");
  EXPECT_EQ(granary({"ls", "--token-file", good}).exit_code, 0);
  EXPECT_EQ(granary({"ls", "--token-file", bad}).exit_code, 5);
  EXPECT_EQ(granary({"ls", "--token-file", scratch_.file("none")}).exit_code, 2);
}

TEST_F(ClientSession, token_is_never_sent_in_clear_text_to_another_machine) {
  environment_["GRANARY_SERVER"] = "grain.example:7443";
  const Outputs outputs = granary({"ls", "--token-file", scratch_.write("token", "sesame")});
  EXPECT_EQ(outputs.exit_code, 5);
  EXPECT_THAT(outputs.err, HasSubstr("clear text"));
}

TEST_F(ClientSession, health_is_ok_while_serving_and_4_while_draining) {
  const Outputs healthy = granary({"health"});
  EXPECT_EQ(healthy.exit_code, 0) << healthy.err;
  EXPECT_THAT(healthy.out, HasSubstr("serving"));
  server_.set_serving(false);
  const Outputs draining = granary({"health"});
  EXPECT_EQ(draining.exit_code, 4);
  EXPECT_THAT(draining.err, IsOneErrorLine());
}

TEST_F(ClientSession, every_code_of_the_server_has_its_exit_code) {
  for (const auto& [status, code] :
       std::vector<std::pair<ErrorCode, int>>{{ErrorCode::invalid_argument, 2},
                                              {ErrorCode::failed_precondition, 2},
                                              {ErrorCode::not_found, 3},
                                              {ErrorCode::permission_denied, 5},
                                              {ErrorCode::unauthenticated, 5},
                                              {ErrorCode::data_loss, 9},
                                              {ErrorCode::internal, 1}}) {
    jobs().fail("List", status, "because\nof this");
    const Outputs outputs = granary({"ls"});
    EXPECT_EQ(outputs.exit_code, code);
    EXPECT_EQ(outputs.err, "granary: because of this\n");
    EXPECT_THAT(outputs.out, IsEmpty());
  }
}

}  // namespace
}  // namespace granary::test
