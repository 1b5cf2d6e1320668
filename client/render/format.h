// The three output formats of every verb. json is stable and documented (client/README.md); table
// is for people and may change.
#pragma once

#include <optional>
#include <string_view>

namespace granary::render {

enum class Format { table, json, csv };

constexpr std::optional<Format> format_from(std::string_view name) {
  if (name == "table") return Format::table;
  if (name == "json") return Format::json;
  if (name == "csv") return Format::csv;
  return std::nullopt;
}

}  // namespace granary::render
