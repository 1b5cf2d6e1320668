#include "client/render/table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

namespace granary::render {
namespace {

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// Tags and lists inside one cell: "a=1 b=2".
std::string compound_text(const Json& cell) {
  std::string text;
  for (const auto& [key, value] : cell.items()) {
    if (!text.empty()) text += ' ';
    if (cell.is_object()) text += key + "=";
    text += value.is_string() ? value.get<std::string>() : compact(value);
  }
  return text;
}

std::string plain_text(const Json& cell) {
  if (cell.is_null()) return "";
  if (cell.is_string()) return cell.get<std::string>();
  if (cell.is_structured()) return compound_text(cell);
  return compact(cell);
}

std::string table_text(const Json& cell) {
  if (cell.is_boolean()) return cell.get<bool>() ? "yes" : "no";
  std::string text = cell.is_number_float() ? rounded(cell.get<double>()) : plain_text(cell);
  return text.empty() ? "-" : printable(text);
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char letter : text) {
    if (letter == '"') quoted += '"';
    quoted += letter;
  }
  return quoted + '"';
}

void append_csv_line(std::string& text, std::span<const std::string> fields) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) text += ',';
    text += csv_field(fields[i]);
  }
  text += '\n';
}

// Code points, not bytes: names and tags may hold any UTF-8.
std::size_t display_width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char byte) { return (byte & 0xC0) != 0x80; }));
}

void append_aligned_line(std::string& text, std::span<const std::string> fields,
                         std::span<const std::size_t> widths, std::span<const char> right) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string padding(widths[i] - display_width(fields[i]), ' ');
    if (i > 0) line += "  ";
    line += right[i] ? padding + fields[i] : fields[i] + padding;
  }
  line.erase(line.find_last_not_of(' ') + 1);
  text += line + '\n';
}

}  // namespace

std::string compact(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

std::string printable(std::string_view text) {
  std::string clean(text);
  for (char& letter : clean)
    if (static_cast<unsigned char>(letter) < 0x20 || letter == 0x7F) letter = ' ';
  return clean;
}

Json row_object(const Table& table, std::size_t row) {
  Json object = Json::object();
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    object[table.columns[i]] = table.rows[row][i];
  return object;
}

std::string as_csv(const Table& table) {
  std::string text;
  append_csv_line(text, table.columns);
  for (const auto& row : table.rows) {
    std::vector<std::string> fields(row.size());
    std::transform(row.begin(), row.end(), fields.begin(), plain_text);
    append_csv_line(text, fields);
  }
  return text;
}

std::string as_aligned_text(const Table& table) {
  const std::size_t column_count = table.columns.size();
  std::vector<std::vector<std::string>> lines{table.columns};
  std::vector<char> right(column_count, 0);  // a column of numbers reads best right-aligned
  for (const auto& row : table.rows) {
    auto& line = lines.emplace_back(column_count);
    std::transform(row.begin(), row.end(), line.begin(), table_text);
    for (std::size_t i = 0; i < column_count; ++i)
      if (row[i].is_number()) right[i] = 1;
  }
  std::vector<std::size_t> widths(column_count, 0);
  for (const auto& line : lines)
    for (std::size_t i = 0; i < column_count; ++i)
      widths[i] = std::max(widths[i], display_width(line[i]));
  std::string text;
  for (const auto& line : lines) append_aligned_line(text, line, widths, right);
  return text;
}

std::string render_rows(const Table& table, Format format, JsonShape shape) {
  if (format == Format::table) return as_aligned_text(table);
  if (format == Format::csv) return as_csv(table);
  if (shape == JsonShape::array) {
    Json array = Json::array();
    for (std::size_t i = 0; i < table.rows.size(); ++i) array.push_back(row_object(table, i));
    return compact(array) + "\n";
  }
  std::string lines;
  for (std::size_t i = 0; i < table.rows.size(); ++i) lines += compact(row_object(table, i)) + "\n";
  return lines;
}

}  // namespace granary::render
