#include "server/jobs/worker_needs.h"

#include <gtest/gtest.h>

namespace granary::server {
namespace {

TEST(WorkerNeeds, equal_needs_are_equal_texts_and_come_back) {
  const Tags tags{{"b", "2=3"}, {"a", ""}};
  EXPECT_EQ(needs_text(tags), "a=\nb=2=3\n");
  EXPECT_EQ(tags_of_needs(needs_text(tags)), tags);
  EXPECT_EQ(needs_text({}), "");
}

TEST(WorkerNeeds, every_tag_must_be_carried_with_its_value) {
  EXPECT_TRUE(fulfils({}, ""));
  EXPECT_TRUE(fulfils({{"a", "1"}, {"b", "2"}}, "a=1\n"));
  EXPECT_FALSE(fulfils({{"a", "2"}}, "a=1\n"));
  EXPECT_FALSE(fulfils({}, "a=1\n"));
}

TEST(WorkerNeeds, what_could_not_be_kept_as_lines_is_refused) {
  EXPECT_TRUE(check_worker_tags({{"cpu", "zen5"}}).ok());
  for (const Tags& bad : {Tags{{"", "x"}}, Tags{{"a=b", "x"}}, Tags{{"a", "x\ny"}}, Tags{{std::string(65, 'a'), ""}}}) {
    const Status status = check_worker_tags(bad);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().field_path, "worker_tags");
  }
}

}  // namespace
}  // namespace granary::server
