// Rows under named columns, and the same rows as an aligned table, CSV or JSON. A cell is a JSON
// value, so numbers keep every digit in csv and json; only the table rounds (6 significant digits).
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/render/format.h"

namespace granary::render {

using Json = nlohmann::ordered_json;

// Invariant: every row has one cell per column. null = unknown: "-" in a table, empty in csv.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<Json>> rows;
};

// How JSON frames the rows: listings are one array, verbs that name their jobs give a line each.
enum class JsonShape { array, lines };

// Text ending in a newline (an empty `lines` table gives an empty string).
std::string render_rows(const Table& table, Format format, JsonShape shape);

std::string as_aligned_text(const Table& table);
std::string as_csv(const Table& table);  // RFC 4180: comma, CRLF-free, quotes doubled
Json row_object(const Table& table, std::size_t row);

// One line. Text that is not UTF-8 (file names) gets replacement characters instead of an
// exception.
std::string compact(const Json& json);

// Non-finite numbers have no JSON form: they become null.
Json number_or_null(double value);

// Control characters of foreign text (tags, logs, error messages) must not reach a terminal.
std::string printable(std::string_view text);

}  // namespace granary::render
