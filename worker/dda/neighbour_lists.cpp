#include "worker/dda/neighbour_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/dda/contact_memory.h"

namespace granary::dda {
namespace {

constexpr double kGroupCells = 2.5;  // width of a motion group / of a search cell
// The horizon: so many steps while disks mix, and longer while neighbours move against each other
// by less than a few skins in it (a bed at rest, a cloud in flight).
constexpr double kMixingHorizonSteps = 10;
constexpr double kLongestHorizonSteps = 200;
constexpr double kHorizonSkins = 2;
constexpr double kNoSpeed = 1e-9;  // m/s
// Collisions may change relative motion by this share of it over a whole horizon.
constexpr double kStrayShare = 0.3;
constexpr double kWallHorizonSteps = 10;
constexpr double kNever = std::numeric_limits<double>::quiet_NaN();  // extents pass over it

Vec2 centre_of(const Disks& disks, std::size_t k) {
  return {disks.pose[k].x, disks.pose[k].y};
}

Vec2 next_centre_of(const Disks& disks, std::size_t k, const SearchFrame& frame) {
  return centre_of(disks, k) + frame.time_step * Vec2{disks.motion[k].vx, disks.motion[k].vy};
}

// Where the velocities lead the disk by the end of the coming step, in the bucket's axes.
Vec2 next_in_bucket(const Disks& disks, std::size_t k, const SearchFrame& frame) {
  return frame.bucket_next.to_body(next_centre_of(disks, k, frame));
}

// Adds the segments of one run within reach; otherwise lowers the clearance that is left.
void search_run(const Walls& walls, const WallRun& run, Vec2 centre, double reach,
                std::int32_t disk, double& clearance, std::vector<NewContact>& found) {
  const double to_run = length(centre - run.centre) - run.radius;
  if (to_run >= reach) {
    clearance = std::min(clearance, to_run);
    return;
  }
  for (std::int32_t s = run.first; s < run.first + run.count; ++s) {
    const double distance =
        distance_to_segment(walls.segments[static_cast<std::size_t>(s)], centre);
    if (distance < reach)
      found.push_back({disk, s, 0, 0});
    else
      clearance = std::min(clearance, distance);
  }
}

bool within(const std::vector<Vec2>& from, const std::vector<double>& clearance, std::size_t k,
            Vec2 position) {
  const Vec2 moved = position - from[k];
  return dot(moved, moved) < clearance[k] * clearance[k];
}

}  // namespace

bool NeighbourLists::pairs_hold(const Disks& disks, const SearchFrame& frame) {
  reference_.age += frame.time_step;
  if (reference_.age > reference_.horizon) return false;
  double largest = 0;
  vectors_.resize(reference_.searched.size());
  for (std::size_t s = 0; s < vectors_.size(); ++s) {
    const std::size_t k = reference_.searched[s];
    const Vec2 predicted = reference_.position[s] + reference_.age * reference_.velocity[s];
    largest = std::max(largest, disks.pose[k].radius);
    vectors_[s] =
        disks.landed[k] ? Vec2{kNever, kNever} : next_in_bucket(disks, k, frame) - predicted;
  }
  return groups_.agree(vectors_, skin_ - 2 * frame.margin_ratio * largest,
                       kStrayShare * reference_.horizon);
}

void NeighbourLists::note_reference(const Disks& disks, const SearchFrame& frame) {
  reference_.searched.clear();
  reference_.position.clear();
  reference_.velocity.clear();
  double largest = 0;
  for (std::size_t k = 0; k < disks.count(); ++k) {
    if (disks.landed[k]) continue;
    const Vec2 position = frame.bucket.to_body(centre_of(disks, k));
    reference_.searched.push_back(static_cast<std::uint32_t>(k));
    reference_.position.push_back(position);
    reference_.velocity.push_back((1 / frame.time_step) *
                                  (next_in_bucket(disks, k, frame) - position));
    largest = std::max(largest, disks.pose[k].radius);
  }
  reference_.cell = kGroupCells * (2 * largest + skin_);
  groups_.group(reference_.position, reference_.cell);
  reference_.reach = 2 * (1 + frame.margin_ratio) * largest;
  groups_.note_speeds(reference_.velocity, reference_.reach);
  // The step that begins now is covered at least.
  const double calm = kHorizonSkins * skin_ / (groups_.largest_relative_speed() + kNoSpeed);
  const double wanted = std::clamp(calm, kMixingHorizonSteps * frame.time_step,
                                   kLongestHorizonSteps * frame.time_step);
  reference_.horizon = std::max(std::min(groups_.time_limit(), wanted), frame.time_step);
  reference_.age = frame.time_step;
}

void NeighbourLists::rebuild_pairs(const Disks& disks, const SearchFrame& frame) {
  note_reference(disks, frame);
  const double half = reference_.horizon / 2;
  search_disks_.clear();
  for (std::size_t s = 0; s < reference_.searched.size(); ++s) {
    const std::size_t k = reference_.searched[s];
    const Vec2 v = reference_.velocity[s], middle = reference_.position[s] + half * v;
    const double speed = groups_.relative_speed(s);
    const double reach = disks.pose[k].radius + skin_ / 2 + kStrayShare * half * speed;
    search_disks_.push_back(
        {middle.x, middle.y, v.x, v.y, reach, half / 2 * speed, static_cast<std::int32_t>(k)});
  }
  search_.find(search_disks_, reference_.horizon, found_pairs_);
  const ContactMemory memory(pairs, disks.rest_index());
  found_.clear();
  for (const DiskPair& pair : found_pairs_) {
    found_.push_back({pair.first, pair.second, 0, 0});
    memory.recall(found_.back());
  }
  colour_contacts(found_, true, disks.rest_index(), disks.rest_index(), pairs);
  ++rebuild_count_;
}

bool NeighbourLists::walls_hold(const Disks& disks, const SearchFrame& frame) const {
  const Reference& r = reference_;
  if (r.clearance.size() != disks.count()) return false;
  for (std::size_t k = 0; k < disks.count(); ++k)
    if (!disks.landed[k] &&
        !within(r.wall_position, r.clearance, k, next_in_bucket(disks, k, frame)))
      return false;
  for (std::size_t k = 0; k < r.clearance_fixed.size(); ++k) {
    if (!disks.landed[k] &&
        !within(r.wall_position_fixed, r.clearance_fixed, k, next_centre_of(disks, k, frame)))
      return false;
  }
  return true;
}

void NeighbourLists::rebuild_walls(const Disks& disks, const Walls& wall_set,
                                   const SearchFrame& frame) {
  const bool some_fixed = std::any_of(wall_set.runs.begin(), wall_set.runs.end(),
                                      [](const WallRun& run) { return !run.moves; });
  Reference& r = reference_;
  r.wall_position.resize(disks.count());
  r.clearance.assign(disks.count(), std::numeric_limits<double>::infinity());
  r.wall_position_fixed.resize(some_fixed ? disks.count() : 0);
  r.clearance_fixed.assign(r.wall_position_fixed.size(), std::numeric_limits<double>::infinity());
  found_.clear();
  for (std::size_t k = 0; k < disks.count(); ++k) {
    const Vec2 world = centre_of(disks, k), body = frame.bucket.to_body(world);
    r.wall_position[k] = body;
    if (some_fixed) r.wall_position_fixed[k] = world;
    if (disks.landed[k]) continue;
    const double radius = disks.pose[k].radius;
    const double path = length(next_in_bucket(disks, k, frame) - body);
    const double path_fixed = length(next_centre_of(disks, k, frame) - world);
    for (const WallRun& run : wall_set.runs)
      search_run(wall_set, run, run.moves ? body : world,
                 radius + skin_ + kWallHorizonSteps * (run.moves ? path : path_fixed),
                 static_cast<std::int32_t>(k), run.moves ? r.clearance[k] : r.clearance_fixed[k],
                 found_);
    const double touching = (1 + frame.margin_ratio) * radius;
    r.clearance[k] -= touching;
    if (some_fixed) r.clearance_fixed[k] -= touching;
  }
  const ContactMemory memory(walls, disks.rest_index());
  for (NewContact& contact : found_) memory.recall(contact);
  colour_contacts(found_, false, disks.rest_index(), 0, walls);
}

void NeighbourLists::refresh(const Disks& disks, const Walls& wall_set, const SearchFrame& frame) {
  if (!pairs_hold(disks, frame)) rebuild_pairs(disks, frame);
  if (!walls_hold(disks, frame)) rebuild_walls(disks, wall_set, frame);
}

void NeighbourLists::restore(const Reference& reference) {
  reference_ = reference;
  if (reference_.cell <= 0) return;
  groups_.group(reference_.position, reference_.cell);
  groups_.note_speeds(reference_.velocity, reference_.reach);
}

}  // namespace granary::dda
