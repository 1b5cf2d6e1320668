#include "worker/dem/slot_list.h"

#include <algorithm>

namespace granary::dem {
namespace {

std::size_t padded(std::size_t count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

}  // namespace

void OuterList::reserve(std::size_t more) {
  const std::size_t needed = count + more + kLanes;
  if (first.size() >= needed) return;
  const std::size_t grown = std::max(needed, first.size() + first.size() / 2);
  first.resize(grown);
  second.resize(grown);
  kind.resize(grown);
}

void OuterList::pad() {
  reserve(0);
  std::fill_n(first.begin() + static_cast<std::ptrdiff_t>(count), kLanes, 0);
  std::fill_n(second.begin() + static_cast<std::ptrdiff_t>(count), kLanes, 0);
  std::fill_n(kind.begin() + static_cast<std::ptrdiff_t>(count), kLanes, 0);
}

History reversed(const History& history) {
  History other = history;
  for (float& value : other.spring) value = -value;
  for (float& value : other.velocity) value = -value;
  return other;
}

SlotArrays SlotList::arrays() {
  const std::size_t third = active_.size() / 3;
  return {count_,         first_.data(),
          second_.data(), kind_.data(),
          foot_.data(),   history_.data(),
          near_.data(),   {active_.data(), active_.data() + third, active_.data() + 2 * third}};
}

void SlotList::clear(std::size_t capacity, bool has_feet) {
  count_ = 0;
  const std::size_t room = padded(capacity) + kLanes;
  if (first_.size() >= room && (!has_feet || foot_.size() >= room)) return;
  first_.resize(room);
  second_.resize(room);
  origin_.resize(room);
  kind_.resize(room);
  history_.resize(room);
  near_.resize(room / kLanes);
  active_.resize(3 * (room + kLanes));
  if (has_feet) foot_.resize(room);
}

void SlotList::seal() {
  for (std::size_t slot = count_; slot < padded(count_) + kLanes && slot < first_.size(); ++slot) {
    first_[slot] = second_[slot] = 0;
    kind_[slot] = 0;
    history_[slot] = {};
  }
  for (std::size_t group = 0; group < padded(count_) / kLanes; ++group) {
    std::uint32_t bits = 0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      bits |= (touching(group * kLanes + lane) ? 1U : 0U) << lane;
    }
    near_[group] = static_cast<std::uint16_t>(bits);
  }
}

}  // namespace granary::dem
