// Which server, token and data directory: option > GRANARY_* environment > config file > default,
// each with where it came from (`granary config show`).
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "proto/contract/result.h"

namespace granary::session {

enum class SettingKey { server, token_file, data, tls_ca, log_level, threads };
inline constexpr std::size_t kSettingCount = 6;

struct SettingName {
  SettingKey key;
  const char* config;       // key in the config file
  const char* environment;  // variable
  const char* option;       // on the command line
  const char* help;
};
inline constexpr std::array<SettingName, kSettingCount> kSettingNames{{
    {SettingKey::server, "server", "GRANARY_SERVER", "--server",
     "server: unix:PATH or HOST:PORT (none: the private server of the data directory)"},
    {SettingKey::token_file, "token_file", "GRANARY_TOKEN_FILE", "--token-file",
     "file that holds the access token"},
    {SettingKey::data, "data", "GRANARY_DATA", "--data", "data directory of the private server"},
    {SettingKey::tls_ca, "tls_ca", "GRANARY_TLS_CA", "--tls-ca",
     "certificate authority (PEM); HOST:PORT servers then use TLS"},
    {SettingKey::log_level, "log_level", "GRANARY_LOG_LEVEL", "--log-level",
     "log level of programs started from here: debug, info, warn or error"},
    {SettingKey::threads, "threads", "GRANARY_THREADS", "--threads",
     "threads of one simulation when the scene does not say (0: the engine's choice)"},
}};

struct Setting {
  std::string value;   // empty: not set
  std::string source;  // "option --server", "environment GRANARY_SERVER", "/x/config.toml:3", ...
};

class Settings {
 public:
  const Setting& operator[](SettingKey key) const { return by_key_[static_cast<std::size_t>(key)]; }
  Setting& operator[](SettingKey key) { return by_key_[static_cast<std::size_t>(key)]; }
  bool names_server() const { return !(*this)[SettingKey::server].value.empty(); }

 private:
  std::array<Setting, kSettingCount> by_key_;
};

using Environment = std::function<std::optional<std::string>(const char* name)>;
std::optional<std::string> process_environment(const char* name);

// $XDG_CONFIG_HOME/granary/config.toml, else ~/.config/granary/config.toml.
std::filesystem::path config_file_path(const Environment& environment);

// `options` holds only what was given on the command line. A missing config file is no error; an
// unreadable one, an unknown key or an impossible value is.
Result<Settings> resolve_settings(const std::map<SettingKey, std::string>& options,
                                  const Environment& environment);

}  // namespace granary::session
