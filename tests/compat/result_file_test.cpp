// result_v1.h5 was written on 2026-11-22 by the first version of the format (the content of
// tests/support/sample_result.cpp then) and is never written again: results live longer than
// programs.
#include <gtest/gtest.h>

#include "tests/support/result_reader.h"
#include "worker/storage/result_reader.h"
#include "worker/storage/verify.h"

namespace granary::storage {
namespace {

const Path kFile = Path(COMPAT_FILES) / "result_v1.h5";

TEST(ResultVersion1, still_verifies) {
  const VerifyReport report = verify_result(kFile);
  EXPECT_TRUE(report.ok()) << report.problems.front();
  EXPECT_EQ(report.frame_count, 3u);
}

TEST(ResultVersion1, paths_and_attributes_are_where_they_were) {
  const granary::testing::StoredResult result = granary::testing::read_result(kFile);
  EXPECT_EQ(result.numbers.at("@format_version"), 1);
  EXPECT_EQ(result.datasets.at("/values/f1_m").as<double>(), std::vector<double>{1.92});
  EXPECT_EQ(result.numbers.at("/values/f1_m@error"), 0.01);
  EXPECT_EQ(result.datasets.at("/frames/000002/position_m").as<double>().at(0), 2);
  EXPECT_EQ(result.numbers.at("/frames/000002@time_s"), 0.5);
  EXPECT_EQ(result.datasets.at("/series/remaining/remaining_percent").as<double>().at(1), 40);
  EXPECT_EQ(result.datasets.at("/ledger/channels/friction").as<double>().at(0), -2);
  EXPECT_EQ(result.texts.at("/provenance@engine_version"), "1.0");
  EXPECT_EQ(result.datasets.at("/provenance/decisions/path").text(), "seed");
}

TEST(ResultVersion1, is_read_by_the_exports) {
  const ResultReader reader(kFile);
  EXPECT_EQ(reader.kind(), "discharge");
  ASSERT_EQ(reader.frame_count(), 3u);
  EXPECT_EQ(reader.frame(1).time_s, 0.25);
}

}  // namespace
}  // namespace granary::storage
