#include "client/session/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/program.h"

namespace granary::session {
namespace {

int exit_code_of_child(pid_t pid) {
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(StartChild, runs_the_program_with_its_output_in_the_log) {
  const test::ScratchDirectory scratch;
  const auto pid = start_child({.command = {"/bin/sh", "-c", "echo out; echo err >&2; exit 3"},
                                .log_file = scratch.file("log")});
  ASSERT_TRUE(pid.ok()) << pid.error().message;
  EXPECT_EQ(exit_code_of_child(*pid), 3);
  EXPECT_EQ(test::file_text(scratch.file("log")), "out\nerr\n");
}

TEST(StartChild, says_why_a_program_cannot_start) {
  const auto pid = start_child({.command = {"/no/such/program"}, .log_file = {}});
  ASSERT_FALSE(pid.ok());
  EXPECT_THAT(pid.error().message, testing::AllOf(testing::HasSubstr("/no/such/program"),
                                                  testing::HasSubstr("No such file")));
}

TEST(StartChild, puts_the_child_out_of_reach_of_the_terminal_s_interrupt) {
  const test::ScratchDirectory scratch;
  const auto pid = start_child({.command = {"/bin/sh", "-c", "cut -d\" \" -f5 /proc/$$/stat"},
                                .log_file = scratch.file("log")});
  ASSERT_TRUE(pid.ok());
  EXPECT_EQ(exit_code_of_child(*pid), 0);
  EXPECT_EQ(std::stoi(test::file_text(scratch.file("log"))), *pid);
  EXPECT_NE(*pid, getpgrp());
}

}  // namespace
}  // namespace granary::session
