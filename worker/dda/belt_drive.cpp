#include "worker/dda/belt_drive.h"

#include <algorithm>

namespace granary::dda {

double BeltDrive::angle_at(double time) const {
  return std::clamp(rotation_rate * time, 0.0, std::numbers::pi);
}

RigidPose BeltDrive::pose_at(double time) const {
  if (rotation_rate == 0) return {};
  if (time < 0) return {1, 0, {0, belt_speed() * time}};
  const double beyond = time - half_turn_time();
  if (beyond > 0) return {-1, 0, {0, -belt_speed() * beyond}};
  return RigidPose::rotated(-angle_at(time));
}

RigidVelocity BeltDrive::velocity_at(double time) const {
  if (time < 0) return {{0, belt_speed()}, 0};
  if (rotation_rate > 0 && time > half_turn_time()) return {{0, -belt_speed()}, 0};
  return {{0, 0}, -rotation_rate};
}

}  // namespace granary::dda
