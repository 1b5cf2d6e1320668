#include "worker/run/series_message.h"

#include <gtest/gtest.h>

#include <numeric>

namespace granary::run {
namespace {

core::Table table_of(std::size_t rows) {
  std::vector<double> time(rows);
  std::iota(time.begin(), time.end(), 0.0);
  return {"flow",
          {core::make_column<double>("time_s", "s", time),
           core::make_column<double>("particle_count", "1", time),
           core::make_column<std::uint32_t>("id", "1", std::vector<std::uint32_t>(rows, 1))}};
}

TEST(SeriesMessage, short_series_are_kept_whole) {
  const std::vector<core::Table> tables = {table_of(kMaxSeriesRows)};
  const v1::SeriesList list = series_message(tables);
  ASSERT_EQ(list.series_size(), 1);
  EXPECT_EQ(list.series(0).time_s_size(), static_cast<int>(kMaxSeriesRows));
  ASSERT_EQ(list.series(0).columns_size(), 1) << "numbers only";
  EXPECT_EQ(list.series(0).columns(0).name(), "particle_count");
}

TEST(SeriesMessage, long_ones_are_thinned_evenly_and_keep_both_ends) {
  for (const std::size_t rows : {201u, 399u, 1000u, 12345u}) {
    const std::vector<core::Table> tables = {table_of(rows)};
    const v1::Series series = series_message(tables).series(0);
    EXPECT_LE(series.time_s_size(), static_cast<int>(kMaxSeriesRows));
    EXPECT_GT(series.time_s_size(), static_cast<int>(kMaxSeriesRows) / 3);
    EXPECT_EQ(series.time_s(0), 0);
    EXPECT_EQ(series.time_s(series.time_s_size() - 1), static_cast<float>(rows - 1));
    EXPECT_EQ(series.columns(0).values_size(), series.time_s_size());
  }
}

TEST(SeriesMessage, tables_without_time_are_no_series) {
  const std::vector<core::Table> tables = {
      {"bucket", {core::make_column<double>("x_m", "m", std::vector<double>{1, 2})}}, table_of(0)};
  const v1::SeriesList list = series_message(tables);
  ASSERT_EQ(list.series_size(), 1);
  EXPECT_EQ(list.series(0).time_s_size(), 0);
}

}  // namespace
}  // namespace granary::run
