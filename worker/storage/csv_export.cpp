#include "worker/storage/csv_export.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "worker/storage/export_files.h"
#include "worker/storage/result_reader.h"

namespace granary::storage {
namespace {

// Files whose columns and their order are part of the product's contract; all others have every
// dataset of the group, time first, then by name.
struct FixedColumns {
  std::string_view table;
  std::array<std::string_view, 4> columns;  // "" = no more
};
constexpr FixedColumns kFixedColumns[] = {
    {"remaining", {"angle_deg", "remaining_percent"}},
    {"cg", {"time_s", "angle_deg", "x_m", "y_m"}},
    {"surface_velocity", {"x_m", "y_m", "streamwise_m_per_s", "spanwise_m_per_s"}},
    {"bed_height", {"x_m", "y_m", "height_m"}},
    {"depth_profile", {"x_m", "height_m", "streamwise_m_per_s", "solid_fraction"}},
};

// The columns to write, in order: those of the contract, or all with the time first.
std::vector<NumberColumn> chosen_columns(NumberTable table) {
  std::erase_if(table.columns, [](const NumberColumn& column) { return column.width != 1; });
  for (const FixedColumns& fixed : kFixedColumns) {
    if (fixed.table != table.name) continue;
    std::vector<NumberColumn> columns;
    for (const std::string_view name : fixed.columns)
      if (const NumberColumn* column = table.find(name)) columns.push_back(*column);
    return columns;
  }
  std::stable_partition(table.columns.begin(), table.columns.end(),
                        [](const NumberColumn& column) { return column.name == "time_s"; });
  return table.columns;
}

// Shortest text that reads back to the same bits.
void append_number(std::string& text, double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  text.append(digits, end);
}

std::string csv_text(const std::vector<NumberColumn>& columns) {
  std::string text;
  for (std::size_t k = 0; k < columns.size(); ++k) text += (k > 0 ? "," : "") + columns[k].name;
  text += '\n';
  for (std::size_t row = 0; row < columns[0].values.size(); ++row) {
    const bool has_data = std::all_of(columns.begin(), columns.end(), [&](const NumberColumn& c) {
      return std::isfinite(c.values[row]);
    });
    if (!has_data) continue;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (k > 0) text += ',';
      append_number(text, columns[k].values[row]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace

std::vector<Path> export_csv(const Path& result, const Path& directory) {
  const ResultReader reader(result);
  make_directory(directory);
  std::vector<Path> written;
  for (const std::string_view group : {"series", "fields"}) {
    for (const std::string& name : reader.table_names(group)) {
      const auto columns = chosen_columns(reader.table(group, name));
      if (columns.empty()) continue;
      check_lengths(name, columns);
      written.push_back(directory / (name + ".csv"));
      write_text(written.back(), csv_text(columns));
    }
  }
  return written;
}

}  // namespace granary::storage
