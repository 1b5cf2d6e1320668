// Forces of the contacts in a list that is about to be replaced, found again by their pair.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/dda/colouring.h"
#include "worker/dda/contact_list.h"

namespace granary::dda {

class ContactMemory {
 public:
  // Keeps the contacts of `list` that carry force; `rest` marks its padding.
  ContactMemory(const CandidateList& list, std::int32_t rest);
  // Fills in the forces of `contact` if it was there.
  void recall(NewContact& contact) const;

 private:
  struct Kept {
    std::int32_t second;
    double normal_force, tangential_force, rolling_force;
  };
  std::vector<std::uint32_t> start_;  // of each first disk
  std::vector<Kept> kept_;
};

}  // namespace granary::dda
