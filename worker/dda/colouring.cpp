#include "worker/dda/colouring.h"

#include <algorithm>
#include <bit>

namespace granary::dda {
namespace {

// Colours 0..63 come from bit sets. A disk with more contacts (very large among very small ones)
// gets one colour of its own for each further contact.
constexpr std::size_t kSharedColours = 64;

// About what fits into a quarter of a core's own cache with its disks.
constexpr std::size_t kBlockContacts = 4096;

class BlockColouring {
 public:
  BlockColouring(bool second_is_disk, std::int32_t rest)
      : second_is_disk_(second_is_disk), used_(static_cast<std::size_t>(rest), 0) {}

  // Colours of the block's contacts.
  const std::vector<std::uint32_t>& choose(std::span<const NewContact> block) {
    colour_.clear();
    std::uint32_t next_single = kSharedColours;
    for (const NewContact& contact : block) {
      std::uint64_t& first = used_[static_cast<std::size_t>(contact.first)];
      std::uint64_t none = 0;
      std::uint64_t& second =
          second_is_disk_ ? used_[static_cast<std::size_t>(contact.second)] : none;
      const auto free = static_cast<std::uint32_t>(std::countr_one(first | second));
      colour_.push_back(free == kSharedColours ? next_single++ : free);
      if (free == kSharedColours) continue;
      first |= std::uint64_t{1} << free;
      second |= std::uint64_t{1} << free;
    }
    for (const NewContact& contact : block) {
      used_[static_cast<std::size_t>(contact.first)] = 0;
      if (second_is_disk_) used_[static_cast<std::size_t>(contact.second)] = 0;
    }
    return colour_;
  }

 private:
  bool second_is_disk_;
  std::vector<std::uint64_t> used_;
  std::vector<std::uint32_t> colour_;
};

// Appends a block, each of its colours padded to whole groups.
void append_block(std::span<const NewContact> block, const std::vector<std::uint32_t>& colour,
                  std::int32_t rest, std::int32_t pad_second, CandidateList& list) {
  std::vector<std::uint32_t> fill(kSharedColours, 0);
  for (const std::uint32_t c : colour) {
    if (c >= fill.size()) fill.resize(c + 1, 0);
    ++fill[c];
  }
  for (std::uint32_t& count : fill) {
    if (count == 0) continue;
    const std::uint32_t begin = list.colour_start.back();
    const std::uint32_t padded = (count + kGroupSize - 1) / kGroupSize * kGroupSize;
    list.colour_start.push_back(begin + padded);
    count = begin;
  }
  const std::size_t size = list.colour_start.back();
  list.first.resize(size, rest);
  list.second.resize(size, pad_second);
  for (auto* forces : {&list.normal_force, &list.tangential_force, &list.rolling_force})
    forces->resize(size, 0);
  for (std::size_t c = 0; c < block.size(); ++c) {
    const std::size_t slot = fill[colour[c]]++;
    list.first[slot] = block[c].first;
    list.second[slot] = block[c].second;
    list.normal_force[slot] = block[c].normal_force;
    list.tangential_force[slot] = block[c].tangential_force;
    list.rolling_force[slot] = block[c].rolling_force;
  }
}

}  // namespace

void colour_contacts(std::span<const NewContact> contacts, bool second_is_disk, std::int32_t rest,
                     std::int32_t pad_second, CandidateList& list) {
  list.first.clear();
  list.second.clear();
  for (auto* forces : {&list.normal_force, &list.tangential_force, &list.rolling_force})
    forces->clear();
  list.colour_start.assign(1, 0);
  BlockColouring colouring(second_is_disk, rest);
  for (std::size_t begin = 0; begin < contacts.size(); begin += kBlockContacts) {
    const auto block = contacts.subspan(begin, std::min(kBlockContacts, contacts.size() - begin));
    append_block(block, colouring.choose(block), rest, pad_second, list);
  }
}

}  // namespace granary::dda
