// Neighbour lists of the block engine: cell order and outer lists, pruning to inner lists, and the
// test that says how long they are good.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "worker/dem/block_engine.h"

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

namespace {

constexpr std::size_t kGrainsPerBlock = 512;
constexpr double kMarginGrowth = 1.5;        // after late contacts
constexpr double kLargestMarginShare = 0.4;  // of the skin

Vec3 position_of(const GrainMotion& m) {
  return {m.position[0], m.position[1], m.position[2]};
}
Vec3 velocity_of(const GrainMotion& m) {
  return {m.velocity[0], m.velocity[1], m.velocity[2]};
}

std::uint32_t local_offset(std::size_t grain, const BlockRange& range) {
  return static_cast<std::uint32_t>((grain - range.first) * sizeof(GrainSurface));
}

template <typename T>
void reorder(std::vector<T>& values, std::span<const std::uint32_t> order) {
  std::vector<T> sorted(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) sorted[k] = values[order[k]];
  values = std::move(sorted);
}

}  // namespace

void BlockEngine::for_blocks(const std::function<void(Block&)>& task) {
  crew_.run([&](unsigned worker) {
    for (std::size_t b = worker; b < block_count_; b += crew_.size()) task(blocks_[b]);
  });
}

void BlockEngine::refresh_lists() {
  const auto start = std::chrono::steady_clock::now();
  for_blocks([this](Block& block) { measure_stray(block); });
  watch();
  if (!trouble_) {
    const bool is_new = order_is_void_ || !order_is_valid();
    if (is_new) rebuild_order();
    for_blocks([this](Block& block) { prune_block(block); });
    note_late_contacts();
    if (is_new) {
      book_first_overlaps();
      divide_work();
    }
    next_refresh_ = (step_ / horizon_ + 1) * horizon_;
  }
  list_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// --------------------------------------------------------------------- how long the order is good

// Distance of every grain from where the mean motion of its block would have carried it, at the end
// of the coming horizon.
void BlockEngine::measure_stray(Block& block) const {
  const double horizon = static_cast<double>(horizon_) * setup_.time_step;
  const double span = static_cast<double>(step_ - ordered_at_) * setup_.time_step + horizon;
  const Vec3 mean_path = block.mean_velocity * span;
  double largest = 0;
  block.is_sound = true;
  block.path_ratio = 0;
  for (std::uint32_t k = block.range.first; k < block.range.first + block.range.count; ++k) {
    const Vec3 off =
        position_of(motion_[k]) + velocity_of(motion_[k]) * horizon - listed_at_[k] - mean_path;
    const double square = dot(off, off);
    if (!std::isfinite(square)) block.is_sound = false;
    largest = std::max(largest, square);
    block.path_ratio = std::max(block.path_ratio, path_ratio(k));
  }
  block.stray = std::sqrt(largest);
}

// A pair outside the outer list was a skin apart when the order was built, and has come closer by
// what both strayed and their blocks moved apart.
bool BlockEngine::order_is_valid() {
  if (step_ - ordered_at_ >= kLongestOrderInHorizons * horizon_) return false;
  const double span = static_cast<double>(step_ - ordered_at_ + horizon_) * setup_.time_step;
  for (std::size_t b = 0; b < block_count_; ++b) {
    const Block& block = blocks_[b];
    double approach = 2 * block.stray;
    if (b + 1 < block_count_) {
      const Block& next = blocks_[b + 1];
      approach = std::max(approach, block.stray + next.stray +
                                        norm(block.mean_velocity - next.mean_velocity) * span);
    }
    if (approach + margin_ > skin_) return false;
    for (const WallRoom& room : block.rooms) {
      if (block.stray + room.approach * span + margin_ > room.gap) return false;
    }
  }
  return true;
}

// -------------------------------------------------------------------------------------- cell order

// Centres of grains in the outer list are closer than this [m].
double BlockEngine::largest_reach() const {
  double largest_radius = 0;
  for (const GrainClass& c : setup_.classes) largest_radius = std::max(largest_radius, c.radius);
  return 2 * largest_radius + skin_;
}

void BlockEngine::rebuild_order() {
  flush_ledger();
  std::vector<KeptSlot> pairs, walls;
  keep_slots(pairs, walls);
  keep_mesh_contacts();
  drop_leavers(pairs, walls);
  cells_.build(motion_, largest_reach());
  sort_grains(pairs, walls);
  cut_blocks();
  cells_.load_coordinates(motion_, surface_);
  listed_at_.resize(motion_.size());
  for_blocks([&](Block& block) { fill_block(block, pairs, walls); });
  count_free();
  order_is_void_ = false;
  ordered_at_ = step_;
  ++order_rebuilds_;
  begin_ledger_span();
}

void BlockEngine::keep_slots(std::vector<KeptSlot>& pairs, std::vector<KeptSlot>& walls) const {
  for (std::size_t b = 0; b < block_count_; ++b) {
    const Block& block = blocks_[b];
    const auto place = [&](std::uint32_t offset) {
      return block.range.first + offset / static_cast<std::uint32_t>(sizeof(GrainSurface));
    };
    for (std::size_t slot = 0; slot < block.pair_slots.size(); ++slot) {
      pairs.push_back({place(block.pair_slots.first(slot)), place(block.pair_slots.second(slot)),
                       block.pair_slots.history(slot)});
    }
    for (std::size_t slot = 0; slot < block.wall_slots.size(); ++slot) {
      walls.push_back({place(block.wall_slots.first(slot)), block.wall_slots.second(slot),
                       block.wall_slots.history(slot)});
    }
  }
}

// Grains beyond the outlet go when the order is rebuilt; until then they fly, touching nothing.
void BlockEngine::drop_leavers(std::vector<KeptSlot>& pairs, std::vector<KeptSlot>& walls) {
  gather_leavers();
  constexpr std::uint32_t kGone = ~0U;
  std::vector<std::uint32_t> place(motion_.size());
  std::uint32_t kept = 0;
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    const bool leaves = motion_[k].position[0] > setup_.outlet_x;
    place[k] = leaves ? kGone : kept++;
    if (leaves && !is_carried(k)) book_transfer(EnergyChannel::outlet, k, -1);
  }
  if (kept == motion_.size()) return;
  move_mesh_contacts(place);
  const auto take = [&](const KeptSlot& slot, bool is_wall) {
    const bool goes = place[slot.first] == kGone || (!is_wall && place[slot.second] == kGone);
    if (goes && slot.history.touched != 0) {
      const Touch touch =
          is_wall ? touch_of_wall(slot.first, slot.second) : touch_of_pair(slot.first, slot.second);
      const Unfinished half = unfinished(touch, slot.history);
      book(EnergyChannel::outlet, elastic_energy(touch, slot.history));
      book(EnergyChannel::normal_damping, half.damping);
      book(EnergyChannel::friction, half.friction);
    }
    return goes;
  };
  std::erase_if(pairs, [&](const KeptSlot& slot) { return take(slot, false); });
  std::erase_if(walls, [&](const KeptSlot& slot) { return take(slot, true); });
  for (KeptSlot& slot : pairs) slot.second = place[slot.second];
  for (std::vector<KeptSlot>* slots : {&pairs, &walls}) {
    for (KeptSlot& slot : *slots) slot.first = place[slot.first];
  }
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    if (place[k] == kGone) continue;
    motion_[place[k]] = motion_[k];
    surface_[place[k]] = surface_[k];
    id_[place[k]] = id_[k];
    class_[place[k]] = class_[k];
    fresh_[place[k]] = fresh_[k];
  }
  motion_.resize(kept);
  surface_.resize(kept);
  id_.resize(kept);
  class_.resize(kept);
  fresh_.resize(kept);
}

namespace {

// Ascending by first, then second, in linear time: few slots share a first.
template <typename Slot>
void sort_slots(std::vector<Slot>& slots, std::size_t grains) {
  std::vector<std::uint32_t> start(grains + 1, 0);
  for (const Slot& slot : slots) ++start[slot.first + 1];
  for (std::size_t k = 1; k < start.size(); ++k) start[k] += start[k - 1];
  std::vector<Slot> sorted(slots.size());
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
  for (const Slot& slot : slots) {
    std::uint32_t at = next[slot.first]++;
    for (; at > start[slot.first] && sorted[at - 1].second > slot.second; --at) {
      sorted[at] = sorted[at - 1];
    }
    sorted[at] = slot;
  }
  slots = std::move(sorted);
}

}  // namespace

void BlockEngine::sort_grains(std::vector<KeptSlot>& pairs, std::vector<KeptSlot>& walls) {
  const std::span<const std::uint32_t> order = cells_.order();
  std::vector<std::uint32_t> place(order.size());
  sorted_motion_.resize(order.size());
  sorted_surface_.resize(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    place[order[k]] = static_cast<std::uint32_t>(k);
    sorted_motion_[k] = motion_[order[k]];
    sorted_surface_[k] = surface_[order[k]];
  }
  motion_.swap(sorted_motion_);
  surface_.swap(sorted_surface_);
  reorder(id_, order);
  reorder(class_, order);
  reorder(fresh_, order);
  for (KeptSlot& slot : pairs) {
    slot.first = place[slot.first];
    slot.second = place[slot.second];
    if (slot.first < slot.second) continue;
    std::swap(slot.first, slot.second);
    slot.history = reversed(slot.history);
  }
  for (KeptSlot& slot : walls) slot.first = place[slot.first];
  move_mesh_contacts(place);
  sort_slots(pairs, order.size());
  sort_slots(walls, order.size());
}

void BlockEngine::cut_blocks() {
  const std::vector<BlockRange> ranges = cells_.cut(kGrainsPerBlock);
  block_count_ = ranges.size();
  if (blocks_.size() < block_count_) blocks_.resize(block_count_);
  for (std::size_t b = 0; b < block_count_; ++b) {
    Block& block = blocks_[b];
    block.range = ranges[b];
    block.inflow = b > 0 ? ranges[b - 1].outflow : 0;
  }
  clear_desks();
}

// ------------------------------------------------------------------------------------- outer lists

void BlockEngine::fill_block(Block& block, std::span<const KeptSlot> pairs,
                             std::span<const KeptSlot> walls) {
  set_reference(block);
  collect_pairs(block);
  collect_walls(block);
  collect_mesh(block);
  inherit_mesh_contacts(block);
  const auto inherit = [&](const OuterList& outer, std::span<const KeptSlot> kept, SlotList& slots,
                           bool is_wall) {
    const auto begin = std::lower_bound(
        kept.begin(), kept.end(), block.range.first,
        [](const KeptSlot& slot, std::uint32_t grain) { return slot.first < grain; });
    slots.clear(outer.count, false);
    std::uint32_t at = 0;
    for (auto slot = begin;
         slot != kept.end() && slot->first < block.range.first + block.range.count; ++slot) {
      const std::uint32_t first = local_offset(slot->first, block.range);
      const std::uint32_t second = is_wall ? slot->second : local_offset(slot->second, block.range);
      while (at < outer.count &&
             (outer.first[at] < first || (outer.first[at] == first && outer.second[at] < second))) {
        ++at;
      }
      if (at == outer.count) break;
      if (outer.first[at] != first || outer.second[at] != second) continue;
      slots.push(first, second, outer.kind[at], at, slot->history);
    }
    slots.seal();
  };
  inherit(block.pairs, pairs, block.pair_slots, false);
  inherit(block.walls, walls, block.wall_slots, true);
}

void BlockEngine::collect_pairs(Block& block) {
  OuterList& list = block.pairs;
  list.clear();
  SearchTask task;
  task.skin = static_cast<float>(skin_ + cells_.rounding());
  task.origin = block.range.first;
  for (std::uint32_t slab = block.range.first_slab; slab < block.range.end_slab; ++slab) {
    for (std::uint32_t y = 0; y < cells_.cells_across(); ++y) {
      for (std::uint32_t z = 0; z < cells_.cells_up(); ++z) {
        if (!cells_.cell_task(slab, y, z, task)) continue;
        list.reserve(CellOrder::most_pairs(task));
        task.first = list.first.data() + list.count;
        task.second = list.second.data() + list.count;
        list.count += kernels_.search(task);
      }
    }
  }
  const auto grain = [&](std::uint32_t offset) {
    return block.range.first + offset / sizeof(GrainSurface);
  };
  if (block.has_carried) {  // they do not feel each other
    std::size_t kept = 0;
    for (std::size_t k = 0; k < list.count; ++k) {
      if (is_carried(grain(list.first[k])) && is_carried(grain(list.second[k]))) continue;
      list.first[kept] = list.first[k];
      list.second[kept++] = list.second[k];
    }
    list.count = kept;
  }
  list.pad();
  const std::size_t classes = setup_.classes.size();
  if (classes == 1) return;
  for (std::size_t k = 0; k < list.count; ++k) {
    list.kind[k] = static_cast<std::uint8_t>(class_[grain(list.first[k])] * classes +
                                             class_[grain(list.second[k])]);
  }
}

void BlockEngine::collect_walls(Block& block) {
  OuterList& list = block.walls;
  list.clear();
  const std::size_t wall_count = setup_.walls.size();
  block.rooms.assign(wall_count, {std::numeric_limits<double>::infinity(), 0});
  for (std::size_t w = 0; w < wall_count; ++w) {
    block.rooms[w].approach = std::max(0.0, -dot(block.mean_velocity, setup_.walls[w].normal));
  }
  for (std::uint32_t k = block.range.first; k < block.range.first + block.range.count; ++k) {
    if (is_carried(k)) continue;
    list.reserve(wall_count);
    for (std::size_t w = 0; w < wall_count; ++w) {
      const Plane& wall = setup_.walls[w];
      const double gap =
          dot(position_of(motion_[k]) - wall.point, wall.normal) - surface_[k].radius;
      if (gap >= skin_) {
        block.rooms[w].gap = std::min(block.rooms[w].gap, gap);
        continue;
      }
      list.first[list.count] = local_offset(k, block.range);
      list.second[list.count] = static_cast<std::uint32_t>(w);
      list.kind[list.count++] = class_[k];
    }
  }
  list.pad();
}

void BlockEngine::set_reference(Block& block) {
  Vec3 sum;
  double farthest = -std::numeric_limits<double>::infinity();
  block.has_carried = false;
  for (std::uint32_t k = block.range.first; k < block.range.first + block.range.count; ++k) {
    listed_at_[k] = position_of(motion_[k]);
    sum += velocity_of(motion_[k]);
    farthest = std::max(farthest, motion_[k].position[0]);
    block.has_carried = block.has_carried || is_carried(k);
  }
  block.mean_velocity = sum * (1.0 / block.range.count);
  const double longest = static_cast<double>(kLongestOrderInHorizons * horizon_) * setup_.time_step;
  block.nears_outlet =
      farthest + largest_reach() + std::max(0.0, block.mean_velocity.x) * longest >=
      setup_.outlet_x;
}

// ------------------------------------------------------------------------------------- inner lists

void BlockEngine::prune_block(Block& block) {
  block.late = 0;
  prune_pairs(block);
  prune_walls(block);
  if (block.nears_outlet) end_mesh_at_outlet(block);
}

bool BlockEngine::ends_at_outlet(Block& block, std::uint32_t first, std::uint32_t second,
                                 bool is_wall, const History* known) const {
  const std::size_t a = block.range.first + first / sizeof(GrainSurface);
  const std::size_t b = is_wall ? a : block.range.first + second / sizeof(GrainSurface);
  if (motion_[a].position[0] <= setup_.outlet_x && motion_[b].position[0] <= setup_.outlet_x) {
    return false;
  }
  if (known == nullptr || known->touched == 0) return true;
  const Touch touch = is_wall ? touch_of_wall(a, second) : touch_of_pair(a, b);
  const Unfinished half = unfinished(touch, *known);
  block.outlet_work += elastic_energy(touch, *known);
  block.sums.normal_damping += half.damping;
  block.sums.friction += half.friction;
  return true;
}

void BlockEngine::prune_pairs(Block& block) {
  block.survivors.resize(block.pairs.count + kLanes);
  PruneTask task;
  task.motion = &motion_[block.range.first];
  task.first = block.pairs.first.data();
  task.second = block.pairs.second.data();
  task.kind = block.pairs.kind.data();
  task.count = block.pairs.count;
  task.laws = &laws_.pairs;
  task.horizon = static_cast<float>(static_cast<double>(horizon_) * setup_.time_step);
  task.margin = static_cast<float>(margin_);
  task.survivors = block.survivors.data();
  const std::size_t count = kernels_.prune(task);

  std::swap(block.pair_slots, block.old_pair_slots);
  block.pair_slots.clear(count, false);
  HistoryCursor cursor(block.old_pair_slots);
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t origin = block.survivors[k] & ~kOverlaps;
    const History* known = cursor.seek(origin);
    if (block.nears_outlet && ends_at_outlet(block, block.pairs.first[origin],
                                             block.pairs.second[origin], false, known)) {
      continue;
    }
    if (known == nullptr && (block.survivors[k] & kOverlaps) != 0) ++block.late;
    block.pair_slots.push(block.pairs.first[origin], block.pairs.second[origin],
                          block.pairs.kind[origin], origin, known != nullptr ? *known : History{});
  }
  block.pair_slots.seal();
}

void BlockEngine::prune_walls(Block& block) {
  const double horizon = static_cast<double>(horizon_) * setup_.time_step;
  std::swap(block.wall_slots, block.old_wall_slots);
  block.wall_slots.clear(block.walls.count, true);
  HistoryCursor cursor(block.old_wall_slots);
  for (std::uint32_t origin = 0; origin < block.walls.count; ++origin) {
    const std::uint32_t first = block.walls.first[origin];
    const Plane& wall = setup_.walls[block.walls.second[origin]];
    const std::size_t grain = block.range.first + first / sizeof(GrainSurface);
    const Vec3 position = position_of(motion_[grain]);
    const double gap = dot(position - wall.point, wall.normal) - surface_[grain].radius;
    const double approach = std::min(0.0, dot(velocity_of(motion_[grain]), wall.normal));
    if (gap + approach * horizon >= margin_) continue;
    const History* known = cursor.seek(origin);
    if (block.nears_outlet &&
        ends_at_outlet(block, first, block.walls.second[origin], true, known)) {
      continue;
    }
    if (known == nullptr && gap < 0) ++block.late;
    block.wall_slots.push(first, block.walls.second[origin], block.walls.kind[origin], origin,
                          known != nullptr ? *known : History{});
    block.wall_slots.set_last_foot(position - wall.normal * gap);
  }
  block.wall_slots.seal();
}

// Grains put in or set free may overlap at once; all others must be listed before they touch.
void BlockEngine::note_late_contacts() {
  const bool are_fresh = std::find(fresh_.begin(), fresh_.end(), 1) != fresh_.end();
  if (are_fresh) return;
  std::uint64_t late = 0;
  for (std::size_t b = 0; b < block_count_; ++b) late += blocks_[b].late;
  late_contacts_ += late;
  if (late > 0) margin_ = std::min(margin_ * kMarginGrowth, kLargestMarginShare * skin_);
}

}  // namespace granary::dem
