// Greedy colouring of contacts: no two contacts of one colour share a disk. First free colour in
// the order given, so the result depends on nothing but the order. Long lists are coloured block by
// block, one block's colours after the other's: a block's disks then stay in the cache while all of
// its contacts are swept, however many disks there are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/dda/contact_list.h"

namespace granary::dda {

struct NewContact {
  std::int32_t first = 0;
  std::int32_t second = 0;
  double normal_force = 0;
  double tangential_force = 0;
  double rolling_force = 0;
};

// Second bodies that are walls (`second_is_disk` false) never conflict. Padding lanes hold `rest`
// as first and `pad_second` as second.
void colour_contacts(std::span<const NewContact> contacts, bool second_is_disk, std::int32_t rest,
                     std::int32_t pad_second, CandidateList& list);

}  // namespace granary::dda
