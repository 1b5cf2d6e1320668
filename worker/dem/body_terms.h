// Motion between contacts: gravity and, in the corotating frame, centrifugal and Coriolis terms
// (Eq. 13, 14) with Crank-Nicolson rotation, so that a free grain is followed to second order.
// The scheme is leapfrog: velocities live at half steps, positions at full steps.
#pragma once

#include "worker/core/vec3.h"
#include "worker/dem/setup.h"

namespace granary::dem {

class BodyTerms {
 public:
  BodyTerms(const Motion& motion, double time_step);

  // Gravity and centrifugal acceleration at x; the Coriolis part is in `kick`.
  core::Vec3 acceleration(const core::Vec3& position) const;
  // Centrifugal part alone: the work it does is the ledger's frame work.
  core::Vec3 centrifugal(const core::Vec3& position) const;

  // v(t - dt/2) -> v(t + dt/2) under acceleration a (contacts included) and Coriolis at the mean.
  core::Vec3 kick(const core::Vec3& velocity_half, const core::Vec3& acceleration) const;
  // Same for the spin relative to the frame: d w/dt = alpha - Omega x w.
  core::Vec3 kick_spin(const core::Vec3& spin_half, const core::Vec3& angular_acceleration) const;

  // Between the full-step velocity users see and the half step before it, body terms only.
  core::Vec3 half_step_back(const core::Vec3& velocity, const core::Vec3& position) const;
  core::Vec3 half_step_on(const core::Vec3& velocity_half, const core::Vec3& position) const;
  core::Vec3 spin_half_step_back(const core::Vec3& spin) const;
  core::Vec3 spin_half_step_on(const core::Vec3& spin_half) const;

  const core::Vec3& frame_omega() const { return omega_; }  // zero in the inertial frame

 private:
  core::Vec3 gravity_;
  core::Vec3 omega_;
  core::Vec3 axis_point_;
  double time_step_;
  bool rotating_;
  core::Mat3 velocity_solve_;  // (I + dt [Omega]x)^-1
  core::Mat3 spin_solve_;      // (I + dt/2 [Omega]x)^-1
};

// Chute axes <-> the engine's axes at time t. Identity in the corotating frame; in the inertial
// frame the chute has turned by Omega t about its axis.
class FrameMap {
 public:
  FrameMap(const Motion& motion, double time);

  core::Vec3 position_in(const core::Vec3& chute) const;
  core::Vec3 velocity_in(const core::Vec3& chute_velocity, const core::Vec3& chute_position) const;
  core::Vec3 spin_in(const core::Vec3& chute_spin) const;
  core::Vec3 direction_in(const core::Vec3& chute) const;

  core::Vec3 position_out(const core::Vec3& engine) const;
  core::Vec3 velocity_out(const core::Vec3& velocity, const core::Vec3& engine_position) const;
  core::Vec3 spin_out(const core::Vec3& spin) const;

  // Velocity of the chute's walls at a point of the engine's axes; zero in the corotating frame.
  core::Vec3 wall_velocity(const core::Vec3& engine_position) const;
  const core::Vec3& wall_spin() const { return wall_omega_; }

 private:
  core::Mat3 to_engine_;
  core::Mat3 to_chute_;
  core::Vec3 wall_omega_;
  core::Vec3 axis_point_;
};

}  // namespace granary::dem
