// Snapshot and restore of the block engine. The order of sums follows the lists, so lists are kept:
// cell order, outer and inner lists, histories. What can be derived from the setup is not.
#include <algorithm>
#include <stdexcept>

#include "worker/dem/block_engine.h"
#include "worker/dem/leaver_columns.h"

namespace granary::dem {
namespace {

using core::Vec3;

constexpr std::size_t kMotionWidth = 8, kSurfaceWidth = 4;
constexpr std::size_t kHistoryWidth = 7;
constexpr std::size_t kBlockIntegers = 11;
constexpr std::size_t kBlockNumbers = 9;

// Slots and outer lists of all blocks, one after the other.
struct ListColumns {
  std::vector<std::uint32_t> outer_first, outer_second, first, second, origin, near;
  std::vector<std::uint8_t> outer_kind, kind;
  std::vector<float> history;
  std::vector<double> foot;

  void add(const OuterList& outer, const SlotList& slots, bool has_feet);
  void take(OuterList& outer, std::size_t outer_count, SlotList& slots, std::size_t slot_count,
            bool has_feet);
  void put(core::State& state, const std::string& name) const;
  void get(const core::State& state, const std::string& name);

 private:
  std::size_t outer_at_ = 0, slot_at_ = 0, near_at_ = 0;
};

void ListColumns::add(const OuterList& outer, const SlotList& slots, bool has_feet) {
  const auto end = static_cast<std::ptrdiff_t>(outer.count);
  outer_first.insert(outer_first.end(), outer.first.begin(), outer.first.begin() + end);
  outer_second.insert(outer_second.end(), outer.second.begin(), outer.second.begin() + end);
  outer_kind.insert(outer_kind.end(), outer.kind.begin(), outer.kind.begin() + end);
  for (std::size_t k = 0; k < slots.size(); ++k) {
    first.push_back(slots.first(k));
    second.push_back(slots.second(k));
    origin.push_back(slots.origin(k));
    kind.push_back(slots.kind(k));
    const History& h = slots.history(k);
    history.insert(history.end(), {h.spring[0], h.spring[1], h.spring[2], h.touched, h.velocity[0],
                                   h.velocity[1], h.velocity[2]});
    if (has_feet) {
      foot.insert(foot.end(), std::begin(slots.foot(k).position), std::end(slots.foot(k).position));
    }
  }
  near.insert(near.end(), slots.near().begin(), slots.near().end());
}

void ListColumns::take(OuterList& outer, std::size_t outer_count, SlotList& slots,
                       std::size_t slot_count, bool has_feet) {
  if (outer_at_ + outer_count > outer_first.size() || slot_at_ + slot_count > first.size() ||
      near_at_ + (slot_count + kLanes - 1) / kLanes > near.size()) {
    throw std::runtime_error("state: lists are shorter than their blocks say");
  }
  outer.clear();
  outer.reserve(outer_count);
  outer.count = outer_count;
  std::copy_n(outer_first.begin() + static_cast<std::ptrdiff_t>(outer_at_), outer_count,
              outer.first.begin());
  std::copy_n(outer_second.begin() + static_cast<std::ptrdiff_t>(outer_at_), outer_count,
              outer.second.begin());
  std::copy_n(outer_kind.begin() + static_cast<std::ptrdiff_t>(outer_at_), outer_count,
              outer.kind.begin());
  outer.pad();
  outer_at_ += outer_count;
  slots.clear(slot_count, has_feet);
  for (std::size_t k = slot_at_; k < slot_at_ + slot_count; ++k) {
    const float* h = &history[k * kHistoryWidth];
    slots.push(first[k], second[k], kind[k], origin[k],
               {{h[0], h[1], h[2]}, h[3], {h[4], h[5], h[6]}, 0});
    if (has_feet) slots.set_last_foot({foot[3 * k], foot[3 * k + 1], foot[3 * k + 2]});
  }
  slots.seal();
  const std::size_t groups = slots.near().size();
  slots.set_near(std::span(near).subspan(near_at_, groups));
  near_at_ += groups;
  slot_at_ += slot_count;
}

void ListColumns::put(core::State& state, const std::string& name) const {
  state.put(name + ".outer_first", "1", outer_first);
  state.put(name + ".outer_second", "1", outer_second);
  state.put(name + ".outer_kind", "1", outer_kind);
  state.put(name + ".first", "1", first);
  state.put(name + ".second", "1", second);
  state.put(name + ".origin", "1", origin);
  state.put(name + ".kind", "1", kind);
  state.put(name + ".near", "1", near);
  state.put(name + ".history", "SI", history, kHistoryWidth);
  state.put(name + ".foot_m", "m", foot, 3);
}

void ListColumns::get(const core::State& state, const std::string& name) {
  outer_first = state.get<std::uint32_t>(name + ".outer_first");
  outer_second = state.get<std::uint32_t>(name + ".outer_second");
  outer_kind = state.get<std::uint8_t>(name + ".outer_kind");
  first = state.get<std::uint32_t>(name + ".first");
  second = state.get<std::uint32_t>(name + ".second");
  origin = state.get<std::uint32_t>(name + ".origin");
  kind = state.get<std::uint8_t>(name + ".kind");
  near = state.get<std::uint32_t>(name + ".near");
  history = state.get<float>(name + ".history");
  foot = state.get<double>(name + ".foot_m");
  if (outer_second.size() != outer_first.size() || outer_kind.size() != outer_first.size() ||
      second.size() != first.size() || origin.size() != first.size() ||
      kind.size() != first.size() || history.size() != first.size() * kHistoryWidth) {
    throw std::runtime_error("state: columns of " + name + " differ in length");
  }
}

}  // namespace

core::State BlockEngine::snapshot() const {
  core::State state;
  const auto* motion = reinterpret_cast<const double*>(motion_.data());
  const auto* surface = reinterpret_cast<const double*>(surface_.data());
  state.put("dem.motion", "SI", std::vector<double>(motion, motion + kMotionWidth * motion_.size()),
            kMotionWidth);
  state.put("dem.surface", "SI",
            std::vector<double>(surface, surface + kSurfaceWidth * surface_.size()), kSurfaceWidth);
  state.put("dem.id", "1", id_);
  state.put("dem.class", "1", class_);
  state.put("dem.fresh", "1", fresh_);
  std::vector<double> listed;
  for (const Vec3& p : listed_at_) listed.insert(listed.end(), {p.x, p.y, p.z});
  state.put("dem.listed_at_m", "m", listed, 3);
  save_lists(state);
  save_mesh(state);
  std::vector<Leaver> leavers = leavers_;
  for (std::size_t b = 0; b < block_count_; ++b) {
    leavers.insert(leavers.end(), blocks_[b].leavers.begin(), blocks_[b].leavers.end());
  }
  put_leavers(state, leavers);
  state.put("dem.counters", "1",
            std::vector<std::uint64_t>{step_, next_refresh_, ordered_at_, particle_steps_,
                                       contact_evaluations_, late_contacts_, order_rebuilds_,
                                       order_is_void_ ? 1U : 0U});
  state.put_scalar("dem.next_id", "1", next_id_);
  const Vec3& g = setup_.motion.gravity;
  state.put("dem.numbers", "SI",
            std::vector<double>{largest_overlap_ratio_, margin_, span_start_.potential,
                                span_start_.centrifugal, g.x, g.y, g.z});
  std::vector<double> ledger(ledger_.channels_j.begin(), ledger_.channels_j.end());
  ledger.insert(ledger.end(), {ledger_.stored_at_start_j, ledger_.throughput_j});
  state.put("dem.ledger_j", "J", ledger);
  return state;
}

void BlockEngine::save_lists(core::State& state) const {
  std::vector<std::uint64_t> integers;
  std::vector<double> numbers, rooms;
  ListColumns pairs, walls;
  for (std::size_t b = 0; b < block_count_; ++b) {
    const Block& block = blocks_[b];
    const BlockRange& r = block.range;
    integers.insert(
        integers.end(),
        {r.first, r.count, r.first_slab, r.end_slab, r.outflow, block.pairs.count,
         block.walls.count, block.pair_slots.size(), block.wall_slots.size(),
         (block.has_carried ? 1U : 0U) | (block.nears_outlet ? 2U : 0U), block.sums.contacts});
    const Vec3& v = block.mean_velocity;
    numbers.insert(numbers.end(), {v.x, v.y, v.z, block.sums.normal_damping, block.sums.friction,
                                   block.sums.rolling, block.sums.largest_overlap_ratio,
                                   block.inlet_work, block.outlet_work});
    for (const WallRoom& room : block.rooms) rooms.insert(rooms.end(), {room.gap, room.approach});
    pairs.add(block.pairs, block.pair_slots, false);
    walls.add(block.walls, block.wall_slots, true);
  }
  state.put("dem.blocks", "1", integers, kBlockIntegers);
  state.put("dem.block_numbers", "SI", numbers, kBlockNumbers);
  state.put("dem.wall_rooms", "SI", rooms, 2);
  pairs.put(state, "dem.pairs");
  walls.put(state, "dem.walls");
}

void BlockEngine::load_lists(const core::State& state) {
  const auto integers = state.get<std::uint64_t>("dem.blocks");
  const auto numbers = state.get<double>("dem.block_numbers");
  const auto rooms = state.get<double>("dem.wall_rooms");
  ListColumns pairs, walls;
  pairs.get(state, "dem.pairs");
  walls.get(state, "dem.walls");
  block_count_ = integers.size() / kBlockIntegers;
  const std::size_t wall_count = setup_.walls.size();
  if (numbers.size() != block_count_ * kBlockNumbers ||
      rooms.size() != block_count_ * wall_count * 2 ||
      walls.foot.size() != 3 * walls.first.size()) {
    throw std::runtime_error("state: blocks of another setup");
  }
  blocks_.clear();
  blocks_.resize(block_count_);
  for (std::size_t b = 0; b < block_count_; ++b) {
    Block& block = blocks_[b];
    const std::uint64_t* i = &integers[b * kBlockIntegers];
    const auto u32 = [&](std::size_t k) { return static_cast<std::uint32_t>(i[k]); };
    block.range = {u32(0), u32(1), u32(2), u32(3), u32(4)};
    block.inflow = b > 0 ? blocks_[b - 1].range.outflow : 0;
    block.has_carried = (i[9] & 1U) != 0;
    block.nears_outlet = (i[9] & 2U) != 0;
    pairs.take(block.pairs, i[5], block.pair_slots, i[7], false);
    walls.take(block.walls, i[6], block.wall_slots, i[8], true);
    const double* n = &numbers[b * kBlockNumbers];
    block.mean_velocity = {n[0], n[1], n[2]};
    block.sums = {n[3], n[4], n[5], static_cast<float>(n[6]), i[10]};
    block.inlet_work = n[7];
    block.outlet_work = n[8];
    for (std::size_t w = 0; w < wall_count; ++w) {
      block.rooms.push_back({rooms[2 * (b * wall_count + w)], rooms[2 * (b * wall_count + w) + 1]});
    }
  }
  clear_desks();
}

void BlockEngine::restore(const core::State& state) {
  const auto motion = state.get<double>("dem.motion");
  const auto surface = state.get<double>("dem.surface");
  const auto listed = state.get<double>("dem.listed_at_m");
  id_ = state.get<std::int64_t>("dem.id");
  class_ = state.get<std::uint8_t>("dem.class");
  fresh_ = state.get<std::uint8_t>("dem.fresh");
  const std::size_t count = id_.size();
  if (motion.size() != kMotionWidth * count || surface.size() != kSurfaceWidth * count ||
      class_.size() != count || fresh_.size() != count || listed.size() > 3 * count) {
    throw std::runtime_error("state: grain columns differ in length");
  }
  for (const std::uint8_t grain_class : class_) {
    if (grain_class >= setup_.classes.size()) {
      throw std::runtime_error("state: grain of a class that the scene does not have");
    }
  }
  motion_.resize(count);
  surface_.resize(count);
  std::copy(motion.begin(), motion.end(), reinterpret_cast<double*>(motion_.data()));
  std::copy(surface.begin(), surface.end(), reinterpret_cast<double*>(surface_.data()));
  listed_at_.clear();
  for (std::size_t k = 0; k < listed.size(); k += 3) {
    listed_at_.push_back({listed[k], listed[k + 1], listed[k + 2]});
  }
  load_lists(state);
  load_mesh(state);
  leavers_ = get_leavers(state);
  load_scalars(state);
  count_free();
  divide_work();
  trouble_.reset();
}

void BlockEngine::load_scalars(const core::State& state) {
  const auto counters = state.get<std::uint64_t>("dem.counters");
  const auto numbers = state.get<double>("dem.numbers");
  const auto ledger = state.get<double>("dem.ledger_j");
  if (counters.size() != 8 || numbers.size() != 7 ||
      ledger.size() != core::kEnergyChannelCount + 2) {
    throw std::runtime_error("state: counters of another version");
  }
  step_ = counters[0];
  next_refresh_ = counters[1];
  ordered_at_ = counters[2];
  particle_steps_ = counters[3];
  contact_evaluations_ = counters[4];
  late_contacts_ = counters[5];
  order_rebuilds_ = counters[6];
  order_is_void_ = counters[7] != 0;
  next_id_ = state.get_scalar<std::int64_t>("dem.next_id");
  largest_overlap_ratio_ = numbers[0];
  margin_ = numbers[1];
  span_start_ = {numbers[2], numbers[3]};
  setup_.motion.gravity = {numbers[4], numbers[5], numbers[6]};
  terms_ = BodyTerms(setup_.motion, setup_.time_step);
  body_ = body_coefficients(setup_);
  ledger_ = {};
  std::copy_n(ledger.begin(), core::kEnergyChannelCount, ledger_.channels_j.begin());
  ledger_.stored_at_start_j = ledger[core::kEnergyChannelCount];
  ledger_.throughput_j = ledger[core::kEnergyChannelCount + 1];
}

}  // namespace granary::dem
