#include "worker/dda/neighbour_lists.h"

#include <algorithm>
#include <cmath>

#include "worker/dda/contact_memory.h"

namespace granary::dda {
namespace {

constexpr std::uint64_t kShortestHorizonSteps = 3;
constexpr std::uint64_t kLongestHorizonSteps = 10;
constexpr double kAllowedDeviation = 0.25;  // of the skin

}  // namespace

void NeighbourLists::predict(const Disks& disks, const std::vector<std::uint8_t>& touched,
                             const SearchFrame& frame) {
  const double w = frame.bucket.turn_rate;
  path_.resize(disks.count());
  for (std::size_t k = 0; k < disks.count(); ++k) {
    const DiskPose& p = disks.pose[k];
    const DiskMotion& v = disks.motion[k];
    path_[k] = {p.x, p.y, v.vx, v.vy, 0, -frame.gravity};
    if (!touched[k]) continue;
    // Constant velocity v' in the turning frame: a = -w^2 r + 2 w x v'.
    const Vec2 bucket = frame.bucket.at({p.x, p.y});
    const double ux = v.vx - bucket.x, uy = v.vy - bucket.y;
    path_[k].ax = -w * w * p.x - 2 * w * uy;
    path_[k].ay = -w * w * p.y + 2 * w * ux;
  }
}

void NeighbourLists::note_step(const Disks& disks, double time_step) {
  ++age_steps_;
  age_ += time_step;
  if (age_steps_ >= horizon_steps_) {
    horizon_steps_ = std::min(horizon_steps_ + horizon_steps_ / 2, kLongestHorizonSteps);
    valid_ = false;
    return;
  }
  const double allowed = kAllowedDeviation * skin_, half = age_ * age_ / 2;
  double worst2 = 0;
  for (std::size_t k = 0; k < path_.size(); ++k) {
    const PredictedPath& path = path_[k];
    const double dx = disks.pose[k].x - (path.x + age_ * path.vx + half * path.ax);
    const double dy = disks.pose[k].y - (path.y + age_ * path.vy + half * path.ay);
    const double deviation2 = disks.landed[k] ? 0 : dx * dx + dy * dy;
    worst2 = std::max(worst2, deviation2);
  }
  if (worst2 <= allowed * allowed) return;
  horizon_steps_ = std::max(age_steps_ + age_steps_ / 2, kShortestHorizonSteps);
  valid_ = false;
}

void NeighbourLists::find_walls(const Disks& disks, const Walls& walls, const SearchFrame& frame,
                                double horizon, std::vector<NewContact>& found) const {
  found.clear();
  for (std::size_t k = 0; k < disks.count(); ++k) {
    if (disks.landed[k]) continue;
    const DiskPose& p = disks.pose[k];
    const DiskMotion& v = disks.motion[k];
    const Vec2 world{p.x, p.y}, velocity{v.vx, v.vy};
    const Vec2 body = frame.bucket_pose.to_body(world);
    const double slack = p.radius + skin_;
    const double moving_reach = slack + horizon * length(velocity - frame.bucket.at(world));
    const double fixed_reach = slack + horizon * length(velocity);
    for (const WallRun& run : walls.runs) {
      const Vec2 centre = run.moves ? body : world;
      const double reach = run.moves ? moving_reach : fixed_reach;
      const Vec2 offset = centre - run.centre;
      const double limit = reach + run.radius;
      if (dot(offset, offset) > limit * limit) continue;
      for (std::int32_t s = run.first; s < run.first + run.count; ++s)
        if (distance_to_segment(walls.segments[static_cast<std::size_t>(s)], centre) < reach)
          found.push_back({static_cast<std::int32_t>(k), s, 0, 0});
    }
  }
}

void NeighbourLists::rebuild(const Disks& disks, const std::vector<std::uint8_t>& touched,
                             const Walls& wall_set, const SearchFrame& frame) {
  const double horizon = static_cast<double>(horizon_steps_) * frame.time_step;
  predict(disks, touched, frame);
  swept_.clear();
  double largest = 0;
  for (std::size_t k = 0; k < disks.count(); ++k) {
    if (disks.landed[k]) continue;
    const DiskPose& p = disks.pose[k];
    const Vec2 bucket = frame.bucket.at({p.x, p.y});
    const double ux = disks.motion[k].vx - bucket.x, uy = disks.motion[k].vy - bucket.y;
    // Seen from the turning frame a parabola bends by the frame's accelerations.
    const double w = frame.bucket.turn_rate;
    const double bend = touched[k] ? 0
                                   : 2 * std::abs(w) * std::hypot(ux, uy) +
                                         w * w * std::hypot(p.x, p.y) + frame.gravity;
    const double pad = skin_ / 2 + bend * horizon * horizon / 2;
    swept_.push_back({p.x, p.y, ux, uy, p.radius + pad, static_cast<std::int32_t>(k)});
    largest = std::max(largest, p.radius);
  }
  search_.find(swept_, horizon, 2 * largest + skin_, found_pairs_);

  const ContactMemory pair_memory(pairs, disks.rest_index());
  found_.clear();
  for (const DiskPair& pair : found_pairs_) {
    found_.push_back({pair.first, pair.second, 0, 0});
    pair_memory.recall(found_.back());
  }
  colour_contacts(found_, true, disks.rest_index(), disks.rest_index(), pairs);

  const ContactMemory wall_memory(walls, disks.rest_index());
  find_walls(disks, wall_set, frame, horizon, found_);
  for (NewContact& contact : found_) wall_memory.recall(contact);
  colour_contacts(found_, false, disks.rest_index(), 0, walls);
  age_steps_ = 0;
  age_ = 0;
  valid_ = true;
  ++rebuild_count_;
}

void NeighbourLists::restore(const Reference& reference) {
  path_ = reference.path;
  age_steps_ = reference.age_steps;
  age_ = reference.age;
  horizon_steps_ = reference.horizon_steps;
  valid_ = reference.valid;
}

}  // namespace granary::dda
