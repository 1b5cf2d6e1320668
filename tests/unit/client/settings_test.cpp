#include "client/session/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/program.h"

namespace granary::session {
namespace {

using testing::HasSubstr;

class SettingsPrecedence : public testing::Test {
 protected:
  void write_config(const std::string& text) {
    std::filesystem::create_directories(home_.file("config/granary"));
    home_.write("config/granary/config.toml", text);
  }
  Result<Settings> resolve(const std::map<SettingKey, std::string>& options = {}) {
    return resolve_settings(options, [this](const char* name) -> std::optional<std::string> {
      const auto found = environment_.find(name);
      if (found == environment_.end()) return std::nullopt;
      return found->second;
    });
  }

  test::ScratchDirectory home_;
  std::map<std::string, std::string> environment_{{"HOME", home_.path()},
                                                  {"XDG_CONFIG_HOME", home_.file("config")}};
};

TEST_F(SettingsPrecedence, option_beats_environment_beats_file_beats_default) {
  auto settings = resolve();
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  EXPECT_FALSE(settings->names_server());
  EXPECT_EQ((*settings)[SettingKey::server].source, "default");

  write_config("\nserver = \"file:1\"\n");
  settings = resolve();
  EXPECT_EQ((*settings)[SettingKey::server].value, "file:1");
  EXPECT_THAT((*settings)[SettingKey::server].source, HasSubstr("config.toml:2"));

  environment_["GRANARY_SERVER"] = "environment:2";
  settings = resolve();
  EXPECT_EQ((*settings)[SettingKey::server].value, "environment:2");
  EXPECT_EQ((*settings)[SettingKey::server].source, "environment GRANARY_SERVER");

  settings = resolve({{SettingKey::server, "option:3"}});
  EXPECT_EQ((*settings)[SettingKey::server].value, "option:3");
  EXPECT_EQ((*settings)[SettingKey::server].source, "option --server");
}

TEST_F(SettingsPrecedence, data_directory_follows_xdg_then_home) {
  EXPECT_EQ((*resolve())[SettingKey::data].value, home_.file(".local/share/granary"));
  environment_["XDG_DATA_HOME"] = "/xdg";
  EXPECT_EQ((*resolve())[SettingKey::data].value, "/xdg/granary");
  environment_["GRANARY_DATA"] = "/srv/granary";
  EXPECT_EQ((*resolve())[SettingKey::data].value, "/srv/granary");
}

TEST_F(SettingsPrecedence, config_file_lies_in_home_without_xdg) {
  environment_.erase("XDG_CONFIG_HOME");
  const auto path = config_file_path([this](const char* name) -> std::optional<std::string> {
    return std::string(name) == "HOME" ? std::optional(home_.path()) : std::nullopt;
  });
  EXPECT_EQ(path, home_.file(".config/granary/config.toml"));
}

TEST_F(SettingsPrecedence, unknown_key_gets_line_and_nearest_name) {
  write_config("threads = 2\nsever = \"a:1\"\n");
  const auto settings = resolve();
  ASSERT_FALSE(settings.ok());
  EXPECT_THAT(settings.error().message,
              testing::AllOf(HasSubstr("config.toml:2"), HasSubstr("'sever'"),
                             HasSubstr("did you mean 'server'")));
}

TEST_F(SettingsPrecedence, impossible_values_name_their_source) {
  for (const auto& [key, value] :
       std::vector<std::pair<SettingKey, const char*>>{{SettingKey::server, "nocolon"},
                                                       {SettingKey::server, "host:70000"},
                                                       {SettingKey::server, ":80"},
                                                       {SettingKey::server, "unix:"},
                                                       {SettingKey::threads, "-1"},
                                                       {SettingKey::threads, "many"},
                                                       {SettingKey::threads, "257"},
                                                       {SettingKey::log_level, "loud"}}) {
    const auto settings = resolve({{key, value}});
    ASSERT_FALSE(settings.ok()) << value;
    EXPECT_EQ(settings.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(settings.error().message, testing::AllOf(HasSubstr("option --"), HasSubstr(value)))
        << value;
  }
}

}  // namespace
}  // namespace granary::session
