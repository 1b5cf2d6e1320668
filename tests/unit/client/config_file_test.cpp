#include "client/session/config_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace granary::session {
namespace {

TEST(ConfigFile, reads_bare_and_quoted_values_and_comments) {
  const auto entries = parse_config(
      "# mine\nserver = grain.example:7443\n\n data = \"/srv/my # data\"  # quoted\n"
      "threads=4 # four\ntoken_file = \"a\\\"b\"\r\n",
      "c.toml");
  ASSERT_TRUE(entries.ok()) << entries.error().message;
  EXPECT_EQ(entries->at("server").value, "grain.example:7443");
  EXPECT_EQ(entries->at("data").value, "/srv/my # data");
  EXPECT_EQ(entries->at("data").line, 4);
  EXPECT_EQ(entries->at("threads").value, "4");
  EXPECT_EQ(entries->at("token_file").value, "a\"b");
}

TEST(ConfigFile, names_file_and_line_of_what_it_cannot_read) {
  for (const auto& [text, message] : std::vector<std::pair<const char*, const char*>>{
           {"server = a\njust words\n", "c.toml:2: expected key = value"},
           {"= 3\n", "c.toml:1: expected key = value"},
           {"data = \"/x\n", "c.toml:1: data: a quote is not closed"},
           {"data = \"/x\" y\n", "c.toml:1: data: text behind the closing quote"},
           {"a = 1\nb = 2\na = 3\n", "c.toml:3: a is given twice"}}) {
    const auto entries = parse_config(text, "c.toml");
    ASSERT_FALSE(entries.ok()) << text;
    EXPECT_EQ(entries.error().message, message);
  }
}

}  // namespace
}  // namespace granary::session
