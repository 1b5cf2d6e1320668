#include "client/session/settings.h"

#include <charconv>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

#include "client/session/config_file.h"
#include "proto/contract/field_path.h"

namespace granary::session {
namespace {

namespace fs = std::filesystem;

fs::path home_of(const Environment& environment) {
  return environment("HOME").value_or("/");
}

std::string default_data(const Environment& environment) {
  if (auto xdg = environment("XDG_DATA_HOME")) return fs::path(*xdg) / "granary";
  return home_of(environment) / ".local" / "share" / "granary";
}

std::string default_of(SettingKey key, const Environment& environment) {
  switch (key) {
    case SettingKey::data:
      return default_data(environment);
    case SettingKey::log_level:
      return "info";
    case SettingKey::threads:
      return "0";
    default:
      return "";
  }
}

Result<std::map<std::string, ConfigEntry>> read_config(const fs::path& path) {
  std::error_code failure;
  if (!fs::exists(path, failure)) return std::map<std::string, ConfigEntry>{};
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) return Error{ErrorCode::invalid_argument, path.string() + ": cannot be read", ""};
  return parse_config(text.str(), path.string());
}

Status refuse_unknown_keys(const std::map<std::string, ConfigEntry>& entries,
                           const fs::path& path) {
  std::vector<std::string> known;
  for (const SettingName& name : kSettingNames) known.push_back(name.config);
  for (const auto& [key, entry] : entries) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string nearest = nearest_name(key, known);
    return Error{ErrorCode::invalid_argument,
                 path.string() + ":" + std::to_string(entry.line) + ": unknown key '" + key + "'" +
                     (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"),
                 key};
  }
  return Done{};
}

bool is_server(const std::string& value) {
  if (value.rfind("unix:", 0) == 0) return value.size() > 5;
  const auto colon = value.rfind(':');
  if (colon == std::string::npos || colon == 0) return false;
  unsigned port = 0;
  const char* end = value.data() + value.size();
  const auto parsed = std::from_chars(value.data() + colon + 1, end, port);
  return parsed.ec == std::errc() && parsed.ptr == end && port <= 65535;
}

bool is_thread_count(const std::string& value) {
  unsigned count = 0;
  const char* end = value.data() + value.size();
  const auto parsed = std::from_chars(value.data(), end, count);
  return parsed.ec == std::errc() && parsed.ptr == end && count <= 256;
}

Status check_value(SettingKey key, const Setting& setting) {
  const auto error = [&](const char* expected) {
    return Error{ErrorCode::invalid_argument,
                 setting.source + ": '" + setting.value + "' is not " + expected, ""};
  };
  if (setting.value.empty()) return Done{};
  if (key == SettingKey::server && !is_server(setting.value))
    return error("a server: unix:PATH or HOST:PORT (port 0 to 65535)");
  if (key == SettingKey::threads && !is_thread_count(setting.value))
    return error("a number of threads (0 to 256)");
  const std::string& level = setting.value;
  if (key == SettingKey::log_level && level != "debug" && level != "info" && level != "warn" &&
      level != "error")
    return error("a log level: debug, info, warn or error");
  return Done{};
}

}  // namespace

std::optional<std::string> process_environment(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr || *value == '\0') return std::nullopt;
  return value;
}

fs::path config_file_path(const Environment& environment) {
  if (auto xdg = environment("XDG_CONFIG_HOME")) return fs::path(*xdg) / "granary" / "config.toml";
  return home_of(environment) / ".config" / "granary" / "config.toml";
}

Result<Settings> resolve_settings(const std::map<SettingKey, std::string>& options,
                                  const Environment& environment) {
  const fs::path path = config_file_path(environment);
  auto entries = read_config(path);
  if (!entries) return entries.error();
  if (auto known = refuse_unknown_keys(*entries, path); !known) return known.error();
  Settings settings;
  for (const SettingName& name : kSettingNames) {
    Setting& setting = settings[name.key];
    const auto entry = entries->find(name.config);
    if (const auto option = options.find(name.key); option != options.end())
      setting = {option->second, std::string("option ") + name.option};
    else if (auto value = environment(name.environment))
      setting = {*value, std::string("environment ") + name.environment};
    else if (entry != entries->end())
      setting = {entry->second.value, path.string() + ":" + std::to_string(entry->second.line)};
    else
      setting = {default_of(name.key, environment), "default"};
    if (auto valid = check_value(name.key, setting); !valid) return valid.error();
  }
  return settings;
}

}  // namespace granary::session
