#include "worker/dda/contact_memory.h"

namespace granary::dda {

ContactMemory::ContactMemory(const CandidateList& list, std::int32_t rest)
    : start_(static_cast<std::size_t>(rest) + 2, 0) {
  const auto carries = [&](std::size_t slot) {
    return list.first[slot] < rest && list.normal_force[slot] != 0;
  };
  for (std::size_t s = 0; s < list.size(); ++s)
    if (carries(s)) ++start_[static_cast<std::size_t>(list.first[s]) + 2];
  for (std::size_t k = 2; k < start_.size(); ++k) start_[k] += start_[k - 1];
  kept_.resize(start_.back());
  for (std::size_t s = 0; s < list.size(); ++s)
    if (carries(s))
      kept_[start_[static_cast<std::size_t>(list.first[s]) + 1]++] = {
          list.second[s], list.normal_force[s], list.tangential_force[s], list.rolling_force[s]};
}

void ContactMemory::recall(NewContact& contact) const {
  const auto first = static_cast<std::size_t>(contact.first);
  for (std::uint32_t k = start_[first]; k < start_[first + 1]; ++k) {
    if (kept_[k].second != contact.second) continue;
    contact.normal_force = kept_[k].normal_force;
    contact.tangential_force = kept_[k].tangential_force;
    contact.rolling_force = kept_[k].rolling_force;
    return;
  }
}

}  // namespace granary::dda
