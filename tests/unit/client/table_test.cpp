#include "client/render/table.h"

#include <gtest/gtest.h>

namespace granary::render {
namespace {

Table sample() {
  return {{"job", "value", "note"}, {{"jobs/1", 1.0 / 3, nullptr}, {"jobs/12", 12, "a,b \"c\""}}};
}

TEST(Table, aligns_columns_rounds_numbers_and_marks_the_unknown) {
  EXPECT_EQ(as_aligned_text(sample()),
            "job         value  note\n"
            "jobs/1   0.333333  -\n"
            "jobs/12        12  a,b \"c\"\n");
}

TEST(Table, csv_quotes_what_needs_it_and_keeps_every_digit) {
  EXPECT_EQ(as_csv(sample()),
            "job,value,note\n"
            "jobs/1,0.3333333333333333,\n"
            "jobs/12,12,\"a,b \"\"c\"\"\"\n");
}

TEST(Table, json_comes_as_one_array_or_a_line_each) {
  const Table table = sample();
  EXPECT_EQ(render_rows(table, Format::json, JsonShape::array),
            "[{\"job\":\"jobs/1\",\"value\":0.3333333333333333,\"note\":null},"
            "{\"job\":\"jobs/12\",\"value\":12,\"note\":\"a,b \\\"c\\\"\"}]\n");
  const std::string lines = render_rows(table, Format::json, JsonShape::lines);
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 2);
  EXPECT_EQ(render_rows({{"job"}, {}}, Format::json, JsonShape::array), "[]\n");
  EXPECT_EQ(render_rows({{"job"}, {}}, Format::json, JsonShape::lines), "");
}

TEST(Table, tags_and_lists_fit_into_one_cell) {
  Table table{{"tags", "tasks"}, {{Json{{"a", "1"}, {"b", "x y"}}, Json::array({"t1", "t2"})}}};
  EXPECT_EQ(as_csv(table), "tags,tasks\na=1 b=x y,t1 t2\n");
}

TEST(Table, never_sends_foreign_control_characters_to_a_terminal) {
  const Table table{{"error"}, {{"bad\x1b[31m\nline"}}};
  EXPECT_EQ(as_aligned_text(table), "error\nbad [31m line\n");
}

TEST(Table, survives_text_that_is_not_utf_8) {
  EXPECT_EQ(render_rows({{"file"}, {{"a\xFF.h5"}}}, Format::json, JsonShape::lines),
            "{\"file\":\"a\xEF\xBF\xBD.h5\"}\n");
}

TEST(Table, counts_characters_not_bytes) {
  const Table table{{"a", "b"}, {{"\xC3\xA4\xC3\xB6", "x"}, {"abc", "y"}}};
  EXPECT_EQ(as_aligned_text(table), "a    b\n\xC3\xA4\xC3\xB6   x\nabc  y\n");
}

TEST(NumberOrNull, knows_that_json_has_no_nan) {
  EXPECT_TRUE(number_or_null(std::nan("")).is_null());
  EXPECT_TRUE(number_or_null(INFINITY).is_null());
  EXPECT_EQ(number_or_null(2.5), 2.5);
}

}  // namespace
}  // namespace granary::render
