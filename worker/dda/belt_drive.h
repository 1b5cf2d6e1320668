// Prescribed motion of the bucket: up the belt, clockwise round the pulley, down the belt.
// Frame (PHYSICS section E): origin = pulley centre, x = throw side, y up; at time 0 the bucket
// reaches theta = 0 on the -x side. Bucket coordinates are world coordinates at theta = 0.
#pragma once

#include <numbers>

#include "worker/dda/rigid_pose.h"

namespace granary::dda {

// Velocity field of a rigid body: v(p) = linear + turn_rate x p, turn_rate > 0 counter-clockwise.
struct RigidVelocity {
  Vec2 linear;
  double turn_rate = 0;  // rad/s

  Vec2 at(Vec2 p) const { return {linear.x - turn_rate * p.y, linear.y + turn_rate * p.x}; }
};

struct BeltDrive {
  double rotation_rate = 0;    // omega [rad/s], clockwise; 0 = the bucket stays at theta = 0
  double pulley_radius = 0.5;  // m

  double belt_speed() const { return rotation_rate * pulley_radius; }
  double half_turn_time() const { return std::numbers::pi / rotation_rate; }
  double angle_at(double time) const;  // theta [rad], 0..pi
  RigidPose pose_at(double time) const;
  RigidVelocity velocity_at(double time) const;
};

}  // namespace granary::dda
