#include "client/session/config_file.h"

#include <algorithm>
#include <cctype>

namespace granary::session {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

bool is_bare_key(std::string_view key) {
  return !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char letter) {
    return std::isalnum(letter) || letter == '_' || letter == '-';
  });
}

// The value behind "=", without quotes and comment.
Result<std::string> parse_value(std::string_view text) {
  if (text.empty() || text.front() != '"')
    return std::string(trimmed(text.substr(0, text.find('#'))));
  std::string value;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '"') {
      const std::string_view rest = trimmed(text.substr(i + 1));
      if (!rest.empty() && rest.front() != '#')
        return Error{ErrorCode::invalid_argument, "text behind the closing quote", ""};
      return value;
    }
    if (text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == '"' || text[i + 1] == '\\')) ++i;
    value += text[i];
  }
  return Error{ErrorCode::invalid_argument, "a quote is not closed", ""};
}

}  // namespace

Result<std::map<std::string, ConfigEntry>> parse_config(std::string_view text,
                                                        std::string_view file_name) {
  std::map<std::string, ConfigEntry> entries;
  int line_number = 0;
  const auto error = [&](const std::string& what) {
    return Error{ErrorCode::invalid_argument,
                 std::string(file_name) + ":" + std::to_string(line_number) + ": " + what, ""};
  };
  while (!text.empty()) {
    const auto end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    const auto equals = line.find('=');
    const std::string key(trimmed(line.substr(0, equals)));
    if (equals == std::string_view::npos || !is_bare_key(key)) return error("expected key = value");
    auto value = parse_value(trimmed(line.substr(equals + 1)));
    if (!value) return error(key + ": " + value.error().message);
    if (!entries.try_emplace(key, ConfigEntry{*value, line_number}).second)
      return error(key + " is given twice");
  }
  return entries;
}

}  // namespace granary::session
