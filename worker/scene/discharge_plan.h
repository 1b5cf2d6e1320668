// What a discharge run does, in SI numbers without any protobuf: built once, never changed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "granary/v1/scene.pb.h"
#include "worker/dda/air_drag.h"
#include "worker/dda/bucket.h"
#include "worker/dda/disks.h"
#include "worker/dda/filling.h"
#include "worker/dda/system.h"

namespace granary::scene {

struct DischargePlan {
  enum class Filling { drop, ordered_compact, stored, placed };

  dda::ContactSettings contact;    // for the whole axial depth
  double filling_stiffness = 1e7;  // N/m, whole axial depth
  double axial_depth = 1;          // m
  dda::SolverSettings solver;      // during the rotation; fillings use IMPULSE, backward Euler
  dda::PenaltyGrowth penalty;      // during the rotation
  double filling_tolerance = 0.3;
  double gravity = 9.81;
  double damping_rate = 0;  // 1/s

  std::optional<dda::BucketGeometry> bucket;
  std::optional<dda::StillAir> air;  // effects.gas ON
  std::vector<dda::Vec2> target;     // closed polygon of the discharge opening; empty = none
  std::vector<std::vector<dda::Vec2>> fixed_walls, moving_walls;
  dda::DiskKind disk_kind;
  dda::Disks placed_disks;  // filling EXPLICIT
  Filling filling = Filling::drop;
  double filling_time_step = 2e-4;

  double pulley_radius = 0.5;
  double rotation_rate = 0;             // rad/s; 0 with rademacher_ka
  std::optional<double> rademacher_ka;  // omega = sqrt(Ka g / |cg|) after the filling
  double run_up = 0;                    // m
  bool starts_with_belt_velocity = false;
  double time_step = 2e-4;
  double end_angle = 3.14159265358979323846;  // rad, where f1..f4 are measured
  std::optional<double> duration;             // s, instead of end_angle
};

// Throws std::invalid_argument for what is no discharge or not built.
DischargePlan make_discharge_plan(const v1::Scene& resolved);

}  // namespace granary::scene
