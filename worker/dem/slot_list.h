// The two lists of a block. Outer: every pair (or grain and wall) that could touch while the cell
// order lasts. Inner: the slots among them that could touch before the next pruning; contact
// history lives there, in groups of lanes, and moves from slot to slot by their place in the outer
// list.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/core/vec3.h"
#include "worker/dem/kernels.h"
#include "worker/dem/records.h"

namespace granary::dem {

// Indices are local to the block, in bytes of GrainSurface. Arrays are padded by kLanes elements.
struct OuterList {
  std::size_t count = 0;
  std::vector<std::uint32_t> first;   // ascending
  std::vector<std::uint32_t> second;  // grain, or number of the wall
  std::vector<std::uint8_t> kind;

  void clear() { count = 0; }
  // Makes room for `more` entries and the padding behind them.
  void reserve(std::size_t more);
  void pad();
};

class SlotList {
 public:
  std::size_t size() const { return count_; }
  SlotArrays arrays();

  // Forgets all slots; `capacity` of them can be pushed.
  void clear(std::size_t capacity, bool has_feet);
  // Precondition: origin (the place in the outer list) ascends from call to call.
  void push(std::uint32_t first, std::uint32_t second, std::uint8_t kind, std::uint32_t origin,
            const History& history) {
    first_[count_] = first;
    second_[count_] = second;
    kind_[count_] = kind;
    origin_[count_] = origin;
    history_[count_++] = history;
  }
  void set_last_foot(const core::Vec3& foot) {
    foot_[count_ - 1] = {{foot.x, foot.y, foot.z}, 0, {}, 0};
  }
  // Call after the last push: makes the padding harmless.
  void seal();

  std::uint32_t first(std::size_t slot) const { return first_[slot]; }
  std::uint32_t second(std::size_t slot) const { return second_[slot]; }
  std::uint32_t origin(std::size_t slot) const { return origin_[slot]; }
  std::uint8_t kind(std::size_t slot) const { return kind_[slot]; }
  const GrainMotion& foot(std::size_t slot) const { return foot_[slot]; }
  const History& history(std::size_t slot) const { return history_[slot]; }
  bool touching(std::size_t slot) const { return history_[slot].touched != 0; }
  // Pairs that were near in the last step, one bit per lane and group.
  std::span<const std::uint16_t> near() const {
    return {near_.data(), (count_ + kLanes - 1) / kLanes};
  }
  void set_near(std::span<const std::uint32_t> near) {
    std::copy(near.begin(), near.end(), near_.begin());
  }

 private:
  std::size_t count_ = 0;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> second_;
  std::vector<std::uint32_t> origin_;
  std::vector<std::uint8_t> kind_;
  LineVector<GrainMotion> foot_;
  LineVector<History> history_;
  std::vector<std::uint16_t> near_;
  std::vector<std::uint32_t> active_;
};

// The velocity of a contact, and its spring, as the other grain sees them.
History reversed(const History& history);

// Walks a slot list by ascending origin.
class HistoryCursor {
 public:
  explicit HistoryCursor(const SlotList& list) : list_(list) {}
  // History of the slot at `origin`, null when there is none.
  const History* seek(std::uint32_t origin) {
    while (slot_ < list_.size() && list_.origin(slot_) < origin) ++slot_;
    if (slot_ == list_.size() || list_.origin(slot_) != origin) return nullptr;
    return &list_.history(slot_);
  }

 private:
  const SlotList& list_;
  std::size_t slot_ = 0;
};

}  // namespace granary::dem
