#include <gtest/gtest.h>

#include "client/commands/jobs.h"

namespace granary::commands {
namespace {

TEST(JobName, takes_the_full_name_and_the_bare_id) {
  EXPECT_EQ(*job_name("jobs/12"), "jobs/12");
  EXPECT_EQ(*job_name("12"), "jobs/12");
  EXPECT_EQ(*job_name("a-b_c.9"), "jobs/a-b_c.9");
}

TEST(JobName, refuses_what_no_job_can_be_called) {
  for (const char* text : {"", "jobs/", "studies/3", "../x", "jobs/a/b", "a b", "x\ny"}) {
    const auto name = job_name(text);
    ASSERT_FALSE(name.ok()) << text;
    EXPECT_EQ(name.error().code, ErrorCode::invalid_argument);
  }
  EXPECT_FALSE(job_name(std::string(200, 'x')).ok());
}

}  // namespace
}  // namespace granary::commands
