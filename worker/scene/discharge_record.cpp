#include "worker/scene/discharge_record.h"

#include <cmath>
#include <numbers>

namespace granary::scene {

using dda::System;
using dda::Vec2;

bool disk_in_bucket(const System& system, const dda::BucketGeometry& bucket, std::size_t disk) {
  const dda::DiskPose& pose = system.disks.pose[disk];
  return bucket.contains(system.bucket_pose(system.time).to_body({pose.x, pose.y}));
}

void sample_discharge(const System& system, const dda::BucketGeometry& bucket, bool force,
                      DischargeRecord& record) {
  const double angle = system.drive.angle_at(system.time) * 180 / std::numbers::pi;
  if (!force && angle < record.next_sample_deg) return;
  record.next_sample_deg = std::floor(angle) + 1;
  const dda::RigidPose pose = system.bucket_pose(system.time);
  double mass = 0, x = 0, y = 0, inside = 0;
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    const dda::DiskPose& disk = system.disks.pose[k];
    const double disk_mass = 1 / system.disks.motion[k].inverse_mass;
    mass += disk_mass;
    x += disk_mass * disk.x;
    y += disk_mass * disk.y;
    if (!system.disks.landed[k] && bucket.contains(pose.to_body({disk.x, disk.y}))) inside += 1;
  }
  record.sample_time.push_back(system.time);
  record.sample_angle_deg.push_back(angle);
  record.sample_remaining.push_back(inside);
  record.sample_cg_x.push_back(x / mass);
  record.sample_cg_y.push_back(y / mass);
}

void note_landings(System& system, const dda::BucketGeometry& bucket, const LandingLevels& levels,
                   DischargeRecord& record) {
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    const dda::DiskPose& pose = system.disks.pose[k];
    if (pose.y >= levels.level || system.disks.landed[k]) continue;
    if (std::isnan(record.landing_x[k])) {
      const dda::DiskMotion& v = system.disks.motion[k];
      // Back along the last step's path to the level.
      const double since = v.vy < 0 ? (pose.y - levels.level) / v.vy : 0;
      record.landing_x[k] = pose.x - since * v.vx;
      record.landed_inside[k] = disk_in_bucket(system, bucket, k) ? 1 : 0;
    }
    if (pose.y < levels.floor) system.disks.landed[k] = 1;
  }
}

void note_target(const System& system, const dda::BucketGeometry& bucket,
                 std::span<const Vec2> target, DischargeRecord& record) {
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    if (record.in_target[k] || system.disks.landed[k]) continue;
    const dda::DiskPose& pose = system.disks.pose[k];
    const dda::DiskMotion& v = system.disks.motion[k];
    const Vec2 now{pose.x, pose.y}, before = now - system.time_step * Vec2{v.vx, v.vy};
    if (dda::enters_polygon(target, before, now) && !disk_in_bucket(system, bucket, k))
      record.in_target[k] = 1;
  }
}

LandingShares landing_shares(const DischargeRecord& record) {
  LandingShares shares;
  for (std::size_t k = 0; k < record.in_target.size(); ++k) {
    if (record.in_target[k])
      ++shares.target;
    else if (!std::isnan(record.landing_x[k]) && !record.landed_inside[k])
      ++shares.leg;
  }
  return shares;
}

void mark_flying(const System& system, const dda::BucketGeometry* bucket,
                 std::vector<std::uint8_t>& flying) {
  flying.assign(system.disks.count(), 0);
  const dda::RigidPose pose = system.bucket_pose(system.time);
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    if (system.disks.landed[k]) continue;
    const Vec2 centre{system.disks.pose[k].x, system.disks.pose[k].y};
    flying[k] = bucket == nullptr || !bucket->contains(pose.to_body(centre));
  }
}

void close_record(const System& system, const dda::BucketGeometry& bucket,
                  DischargeRecord& record) {
  sample_discharge(system, bucket, true, record);
  record.remaining_at_end = record.sample_remaining.back();
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    if (!system.disks.landed[k] && disk_in_bucket(system, bucket, k)) continue;
    const dda::DiskPose& pose = system.disks.pose[k];
    record.flying_at_end.push_back({pose.x, pose.y, 1 / system.disks.motion[k].inverse_mass});
    record.discharged_mass += record.flying_at_end.back().mass;
  }
  record.ended = true;
}

std::vector<measure::FlyingDisk> landed_disks(const System& system, const DischargeRecord& record) {
  std::vector<measure::FlyingDisk> landed;
  for (std::size_t k = 0; k < record.landing_x.size(); ++k)
    if (!std::isnan(record.landing_x[k]) && !record.landed_inside[k])
      landed.push_back({record.landing_x[k], 0, 1 / system.disks.motion[k].inverse_mass});
  return landed;
}

}  // namespace granary::scene
