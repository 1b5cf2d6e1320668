// Tokens and TLS with the real programs: who is let in, with what, and what everybody else is told.
#include <gmock/gmock.h>
#include <signal.h>

#include "tests/support/real_service.h"

namespace granary::test {
namespace {

using testing::HasSubstr;

class AccessService : public RealService {
 protected:
  void SetUp() override {}  // each test starts its own server

  std::string new_token(const std::string& role, const std::string& more = "") {
    std::vector<std::string> command = {GRANARY_BIN "/granaryd", "token", "--tokens", scratch.file("tokens"),
                                        "--role", role, "--owner", "anna" + more};
    const Outputs made = run_program({.command = command, .environment = {}, .input = "", .on_terminal = false});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    return scratch.write(role + more + ".token", made.out);
  }
  void start_guarded(std::vector<std::string> more = {}) {
    std::vector<std::string> command = {GRANARY_BIN "/granaryd", "--data", scratch.file("data"), "--listen",
                                        address, "--tokens", scratch.file("tokens")};
    command.insert(command.end(), more.begin(), more.end());
    server = std::make_unique<Program>(ProgramOptions{.command = command, .environment = {}, .input = "", .on_terminal = false});
    ASSERT_TRUE(server->prints("listening on")) << server->err();
  }
  Outputs with_token(const std::string& file, std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--token-file", file});
    return granary(arguments);
  }
  Program& worker_with(const std::string& token_file, std::vector<std::string> more = {}) {
    std::vector<std::string> command = {GRANARY_BIN "/granary-worker", "--server", address, "--work-dir",
                                        scratch.file("work"), "--token-file", token_file};
    command.insert(command.end(), more.begin(), more.end());
    workers.push_back(std::make_unique<Program>(ProgramOptions{.command = command, .environment = {}, .input = "", .on_terminal = false}));
    return *workers.back();
  }
};

TEST_F(AccessService, each_role_may_do_its_own_and_no_more) {
  const std::string read = new_token("read"), submit = new_token("submit"), work = new_token("worker"), admin = new_token("admin");
  start_guarded();
  EXPECT_EQ(granary({"ls"}).exit_code, 5) << "no token";
  EXPECT_EQ(with_token(scratch.write("wrong", std::string(64, 'a')), {"ls"}).exit_code, 5);
  EXPECT_EQ(granary({"health"}).exit_code, 0) << "health is open";
  EXPECT_EQ(with_token(read, {"ls"}).exit_code, 0);
  EXPECT_EQ(with_token(read, {"submit", scene("discharge_small")}).exit_code, 5);
  EXPECT_EQ(with_token(work, {"ls"}).exit_code, 5);
  ASSERT_EQ(with_token(submit, {"submit", scene("discharge_small")}).exit_code, 0);
  EXPECT_EQ(with_token(read, {"cancel", "jobs/1"}).exit_code, 5);
  EXPECT_EQ(worker_with(read).wait(), 1) << "a reader is no worker";
  EXPECT_TRUE(worker_with(work).prints("event=connected"));
  EXPECT_EQ(with_token(submit, {"watch", "jobs/1"}).exit_code, 0);
  const Outputs listed = with_token(admin, {"status", "jobs/1", "--format", "json"});
  EXPECT_EQ(nlohmann::json::parse(listed.out)["owner"], "anna");
}

TEST_F(AccessService, a_withdrawn_token_is_refused_at_once_and_no_token_is_logged) {
  const std::string read = new_token("read");
  start_guarded();
  ASSERT_EQ(with_token(read, {"ls"}).exit_code, 0);
  scratch.write("tokens", "# none\n");
  EXPECT_TRUE(eventually([&] { return with_token(read, {"ls"}).exit_code == 5; }));
  server->signal(SIGTERM);
  server->wait();
  server->collect_output();
  EXPECT_THAT(server->err(), testing::Not(HasSubstr(file_text(read).substr(0, 64))));
}

TEST_F(AccessService, any_other_address_without_tls_and_token_is_refused) {
  for (const char* open : {"0.0.0.0:0", "192.168.0.1:0"}) {
    const Outputs refused = run_program({.command = {GRANARY_BIN "/granaryd", "--data", scratch.file("data"), "--listen", open},
                                         .environment = {}, .input = "", .on_terminal = false});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr("needs TLS and a token"));
  }
}

TEST_F(AccessService, tls_carries_the_whole_main_job_and_plain_text_gets_nothing) {
  const std::string key = scratch.file("key.pem"), certificate = scratch.file("cert.pem");
  const Outputs made = run_program({.command = {"/usr/bin/openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2",
                                                "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1",
                                                "-keyout", key, "-out", certificate},
                                    .environment = {}, .input = "", .on_terminal = false});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string admin = new_token("admin");
  address = "127.0.0.1:0";
  start_guarded({"--tls-cert", certificate, "--tls-key", key});
  const std::string said = server->out();
  address = said.substr(said.find("127.0.0.1:"), said.find('\n') - said.find("127.0.0.1:"));
  EXPECT_EQ(with_token(admin, {"ls"}).exit_code, 4) << "plain text to a TLS port";
  ASSERT_TRUE(worker_with(admin, {"--tls-ca", certificate}).prints("event=connected")) << workers.back()->err();
  const Outputs ran = with_token(admin, {"run", scene("discharge_small"), "--format", "json", "--tls-ca", certificate});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
}

}  // namespace
}  // namespace granary::test
