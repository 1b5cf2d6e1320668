#include "worker/dem/body_terms.h"

namespace granary::dem {

using core::Vec3;

BodyTerms::BodyTerms(const Motion& motion, double time_step)
    : gravity_(motion.gravity),
      omega_(motion.frame == FrameKind::corotating ? motion.omega : Vec3{}),
      axis_point_(motion.axis_point),
      time_step_(time_step),
      rotating_(omega_ != Vec3{}),
      velocity_solve_(core::inverse_of_one_plus_cross(omega_ * time_step)),
      spin_solve_(core::inverse_of_one_plus_cross(omega_ * (0.5 * time_step))) {}

Vec3 BodyTerms::centrifugal(const Vec3& position) const {
  if (!rotating_) return {};
  return cross(cross(omega_, position - axis_point_), omega_);
}

Vec3 BodyTerms::acceleration(const Vec3& position) const {
  return gravity_ + centrifugal(position);
}

Vec3 BodyTerms::kick(const Vec3& velocity_half, const Vec3& acceleration) const {
  if (!rotating_) return velocity_half + acceleration * time_step_;
  return velocity_solve_ *
         (velocity_half + (acceleration - cross(omega_, velocity_half)) * time_step_);
}

Vec3 BodyTerms::kick_spin(const Vec3& spin_half, const Vec3& angular_acceleration) const {
  if (!rotating_) return spin_half + angular_acceleration * time_step_;
  return spin_solve_ *
         (spin_half + (angular_acceleration - cross(omega_, spin_half) * 0.5) * time_step_);
}

Vec3 BodyTerms::half_step_back(const Vec3& velocity, const Vec3& position) const {
  return velocity - (acceleration(position) - 2 * cross(omega_, velocity)) * (0.5 * time_step_);
}

Vec3 BodyTerms::half_step_on(const Vec3& velocity_half, const Vec3& position) const {
  return velocity_half +
         (acceleration(position) - 2 * cross(omega_, velocity_half)) * (0.5 * time_step_);
}

Vec3 BodyTerms::spin_half_step_back(const Vec3& spin) const {
  return spin + cross(omega_, spin) * (0.5 * time_step_);
}

Vec3 BodyTerms::spin_half_step_on(const Vec3& spin_half) const {
  return spin_half - cross(omega_, spin_half) * (0.5 * time_step_);
}

FrameMap::FrameMap(const Motion& motion, double time)
    : wall_omega_(motion.frame == FrameKind::inertial ? motion.omega : Vec3{}),
      axis_point_(motion.axis_point) {
  to_engine_ = core::rotation_matrix(wall_omega_ * time);
  to_chute_ = transpose(to_engine_);
}

Vec3 FrameMap::position_in(const Vec3& chute) const {
  return axis_point_ + to_engine_ * (chute - axis_point_);
}

Vec3 FrameMap::velocity_in(const Vec3& chute_velocity, const Vec3& chute_position) const {
  return to_engine_ * (chute_velocity + cross(wall_omega_, chute_position - axis_point_));
}

Vec3 FrameMap::spin_in(const Vec3& chute_spin) const {
  return to_engine_ * (chute_spin + wall_omega_);
}

Vec3 FrameMap::direction_in(const Vec3& chute) const {
  return to_engine_ * chute;
}

Vec3 FrameMap::position_out(const Vec3& engine) const {
  return axis_point_ + to_chute_ * (engine - axis_point_);
}

Vec3 FrameMap::velocity_out(const Vec3& velocity, const Vec3& engine_position) const {
  return to_chute_ * (velocity - cross(wall_omega_, engine_position - axis_point_));
}

Vec3 FrameMap::spin_out(const Vec3& spin) const {
  return to_chute_ * (spin - wall_omega_);
}

Vec3 FrameMap::wall_velocity(const Vec3& engine_position) const {
  return cross(wall_omega_, engine_position - axis_point_);
}

}  // namespace granary::dem
