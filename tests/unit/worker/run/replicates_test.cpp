#include "worker/run/replicates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace granary::run {
namespace {

FinishedReplicate replicate(std::optional<double> f1, double remainder_j = 0) {
  FinishedReplicate made;
  made.values = {{"f1_m", "m", f1, {}, f1 ? "" : "nothing left the bucket"}};
  made.state_hash = "hash" + std::to_string(f1.value_or(0));
  made.ledger.kinetic_j = remainder_j;
  made.ledger.throughput_j = 1;
  return made;
}

TEST(Replicates, first_keeps_the_seed_of_the_scene_and_others_differ) {
  EXPECT_EQ(replicate_seed(42, 0), 42u);
  std::set<std::uint64_t> seeds;
  for (std::uint64_t scene_seed : {0, 1, 2})
    for (std::uint32_t i = 0; i < 100; ++i) seeds.insert(replicate_seed(scene_seed, i));
  EXPECT_EQ(seeds.size(), 300u);
}

TEST(Replicates, give_the_mean_and_the_half_width_of_the_t_interval) {
  const auto values = combine_values({replicate(1), replicate(2), replicate(3)});
  ASSERT_EQ(values.size(), 1u);
  EXPECT_DOUBLE_EQ(*values[0].value, 2);
  EXPECT_NEAR(*values[0].error, 4.30265 / std::sqrt(3.0), 1e-4);  // t(0.95, 2) s / sqrt(3), s = 1
  EXPECT_EQ(values[0].error_basis, "95 % t-interval of 3 replicates");
}

TEST(Replicates, value_unknown_in_one_is_unknown) {
  const auto values = combine_values({replicate(1), replicate({}), replicate(3)});
  EXPECT_FALSE(values[0].value);
  EXPECT_FALSE(values[0].error);
  EXPECT_EQ(values[0].error_basis, "known in 2 of 3 replicates");
}

TEST(Replicates, single_run_says_why_it_has_no_error_bar) {
  EXPECT_EQ(combine_values({replicate(1)})[0].error_basis, "single run: set replicates");
  EXPECT_EQ(combine_values({replicate({})})[0].error_basis, "nothing left the bucket");
  FinishedReplicate own = replicate(1);
  own.values[0].error = 0.1;
  own.values[0].error_basis = "blocking";
  EXPECT_EQ(*combine_values({own})[0].error, 0.1);
  EXPECT_EQ(combine_values({own})[0].error_basis, "blocking");
}

TEST(Replicates, state_hash_depends_on_each_and_on_their_order) {
  EXPECT_EQ(combine_state_hashes({replicate(1)}), replicate(1).state_hash);
  const std::string ab = combine_state_hashes({replicate(1), replicate(2)});
  EXPECT_NE(ab, combine_state_hashes({replicate(2), replicate(1)}));
  EXPECT_NE(ab, combine_state_hashes({replicate(1), replicate(3)}));
}

TEST(Replicates, worst_ledger_is_the_one_told) {
  EXPECT_DOUBLE_EQ(
      worst_ledger({replicate(1, 0.1), replicate(2, 0.3), replicate(3, 0.2)}).kinetic_j, 0.3);
}

}  // namespace
}  // namespace granary::run
