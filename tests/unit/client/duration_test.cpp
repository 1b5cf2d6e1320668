#include "client/commands/duration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace granary::commands {
namespace {

TEST(Duration, reads_every_form_people_write) {
  for (const auto& [text, seconds] :
       std::vector<std::pair<const char*, double>>{{"90", 90},
                                                   {"90s", 90},
                                                   {"10m", 600},
                                                   {"2h", 7200},
                                                   {"1.5h", 5400},
                                                   {"1h30m", 5400},
                                                   {"1d2h3m4s", 93784},
                                                   {"0.25", 0.25}}) {
    const auto parsed = parse_duration_s(text);
    ASSERT_TRUE(parsed.ok()) << text;
    EXPECT_DOUBLE_EQ(*parsed, seconds) << text;
  }
}

TEST(Duration, refuses_what_is_not_a_duration_and_says_what_is) {
  for (const char* text : {"", "0", "-5", "10x", "m", "1h1h", "30m1h", "1h30", "inf", "nan", "1e9",
                           "367d", " 5", "5 m", "1,5h"}) {
    const auto parsed = parse_duration_s(text);
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_THAT(parsed.error().message, testing::HasSubstr("90s, 10m, 2h")) << text;
  }
}

}  // namespace
}  // namespace granary::commands
