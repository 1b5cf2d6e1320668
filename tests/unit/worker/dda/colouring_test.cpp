#include "worker/dda/colouring.h"

#include <gtest/gtest.h>

#include <set>

#include "worker/core/random.h"

namespace granary::dda {
namespace {

std::vector<NewContact> random_contacts(std::int32_t disks, int count) {
  std::vector<NewContact> contacts;
  for (int k = 0; k < count; ++k) {
    const auto i = static_cast<std::int32_t>(core::random_bits(1, 1, k) % disks);
    const auto j = static_cast<std::int32_t>(core::random_bits(1, 2, k) % disks);
    if (i != j) contacts.push_back({std::min(i, j), std::max(i, j), 1.0 + k, -1.0 * k});
  }
  return contacts;
}

void expect_proper(const std::vector<NewContact>& contacts, std::int32_t disks) {
  CandidateList list;
  colour_contacts(contacts, true, disks, disks, list);
  std::size_t found = 0;
  for (std::size_t c = 0; c + 1 < list.colour_start.size(); ++c) {
    EXPECT_EQ(list.colour_start[c] % kGroupSize, 0u);
    std::set<std::int32_t> seen;
    for (std::size_t s = list.colour_start[c]; s < list.colour_start[c + 1]; ++s) {
      if (list.first[s] == disks) continue;
      ++found;
      EXPECT_TRUE(seen.insert(list.first[s]).second);
      EXPECT_TRUE(seen.insert(list.second[s]).second);
    }
  }
  EXPECT_EQ(found, contacts.size());
}

TEST(Colouring, puts_no_disk_twice_into_one_colour) {
  expect_proper(random_contacts(300, 900), 300);
}

TEST(Colouring, colours_long_lists_block_by_block) {
  expect_proper(random_contacts(6000, 20000), 6000);
}

TEST(Colouring, copes_with_a_disk_that_has_more_than_64_contacts) {
  std::vector<NewContact> star;
  for (std::int32_t k = 1; k <= 100; ++k) star.push_back({0, k, 1, 0});
  expect_proper(star, 101);
}

TEST(Colouring, keeps_forces_with_their_contacts) {
  const auto contacts = random_contacts(50, 60);
  CandidateList list;
  colour_contacts(contacts, true, 50, 50, list);
  double normal = 0, tangential = 0, expected_normal = 0, expected_tangential = 0;
  for (std::size_t s = 0; s < list.size(); ++s)
    normal += list.normal_force[s] * (list.first[s] + 1),
        tangential += list.tangential_force[s] * (list.second[s] + 1);
  for (const NewContact& c : contacts)
    expected_normal += c.normal_force * (c.first + 1),
        expected_tangential += c.tangential_force * (c.second + 1);
  EXPECT_DOUBLE_EQ(normal, expected_normal);
  EXPECT_DOUBLE_EQ(tangential, expected_tangential);
}

}  // namespace
}  // namespace granary::dda
