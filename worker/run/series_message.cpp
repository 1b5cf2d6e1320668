#include "worker/run/series_message.h"

#include <algorithm>
#include <vector>

namespace granary::run {
namespace {

const core::Column* time_column(const core::Table& table) {
  for (const core::Column& column : table.columns)
    if (column.name == "time_s") return &column;
  return nullptr;
}

// The last row stays: it is the one that the final values are about.
std::vector<std::size_t> kept_rows(std::size_t count) {
  std::vector<std::size_t> rows;
  if (count == 0) return rows;
  const std::size_t gaps = kMaxSeriesRows - 1;
  const std::size_t stride = std::max<std::size_t>(1, (count - 1 + gaps - 1) / gaps);
  for (std::size_t row = 0; row + 1 < count; row += stride) rows.push_back(row);
  rows.push_back(count - 1);
  return rows;
}

bool is_a_series(const core::Column& column, std::size_t rows) {
  return column.type == core::ElementType::f64 && column.width == 1 && column.rows == rows;
}

v1::Series thinned(const core::Table& table, const core::Column& time) {
  v1::Series series;
  series.set_name(table.name);
  const auto rows = kept_rows(time.rows);
  for (const std::size_t row : rows) series.add_time_s(static_cast<float>(time.as<double>()[row]));
  for (const core::Column& column : table.columns) {
    if (&column == &time || !is_a_series(column, time.rows)) continue;
    v1::Series::Column& values = *series.add_columns();
    values.set_name(column.name);
    for (const std::size_t row : rows)
      values.add_values(static_cast<float>(column.as<double>()[row]));
  }
  return series;
}

}  // namespace

v1::SeriesList series_message(std::span<const core::Table> tables) {
  v1::SeriesList list;
  for (const core::Table& table : tables)
    if (const core::Column* time = time_column(table); time && is_a_series(*time, time->rows))
      *list.add_series() = thinned(table, *time);
  return list;
}

}  // namespace granary::run
