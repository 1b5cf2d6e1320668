#include "worker/dda/colouring.h"

#include <bit>

namespace granary::dda {
namespace {

// Colours 0..63 come from bit sets. A disk with more contacts (very large among very small ones)
// gets one colour of its own for each further contact.
constexpr std::size_t kSharedColours = 64;

std::vector<std::uint32_t> choose_colours(std::span<const NewContact> contacts, bool second_is_disk,
                                          std::int32_t rest) {
  std::vector<std::uint64_t> used(static_cast<std::size_t>(rest), 0);
  std::vector<std::uint32_t> colour(contacts.size());
  std::uint32_t next_single = kSharedColours;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    std::uint64_t& first = used[static_cast<std::size_t>(contacts[c].first)];
    std::uint64_t none = 0;
    std::uint64_t& second =
        second_is_disk ? used[static_cast<std::size_t>(contacts[c].second)] : none;
    const auto free = static_cast<std::uint32_t>(std::countr_one(first | second));
    if (free == kSharedColours) {
      colour[c] = next_single++;
      continue;
    }
    first |= std::uint64_t{1} << free;
    second |= std::uint64_t{1} << free;
    colour[c] = free;
  }
  return colour;
}

}  // namespace

void colour_contacts(std::span<const NewContact> contacts, bool second_is_disk, std::int32_t rest,
                     std::int32_t pad_second, CandidateList& list) {
  const std::vector<std::uint32_t> colour = choose_colours(contacts, second_is_disk, rest);
  std::vector<std::uint32_t> fill(kSharedColours, 0);
  for (const std::uint32_t c : colour) {
    if (c >= fill.size()) fill.resize(c + 1, 0);
    ++fill[c];
  }
  list.colour_start.assign(1, 0);
  for (std::size_t c = 0; c < fill.size(); ++c) {
    if (fill[c] == 0) continue;
    const std::uint32_t begin = list.colour_start.back();
    const std::uint32_t padded = (fill[c] + kGroupSize - 1) / kGroupSize * kGroupSize;
    list.colour_start.push_back(begin + padded);
    fill[c] = begin;
  }
  const std::size_t size = list.colour_start.back();
  list.first.assign(size, rest);
  list.second.assign(size, pad_second);
  list.normal_force.assign(size, 0);
  list.tangential_force.assign(size, 0);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::size_t slot = fill[colour[c]]++;
    list.first[slot] = contacts[c].first;
    list.second[slot] = contacts[c].second;
    list.normal_force[slot] = contacts[c].normal_force;
    list.tangential_force[slot] = contacts[c].tangential_force;
  }
}

}  // namespace granary::dda
