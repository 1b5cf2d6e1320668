#include "worker/scene/discharge_plan.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "proto/contract/contact_effects.h"

namespace granary::scene {
namespace {

using std::numbers::pi;

double radians(double degrees) {
  return degrees * pi / 180;
}

template <typename T>
double value_or(bool there, T value, double fallback) {
  return there ? static_cast<double>(value) : fallback;
}

dda::Vec2 point_of(const v1::Point2& point) {
  return {point.x_m(), point.y_m()};
}

std::vector<dda::Vec2> outer_wall(const v1::Bucket& bucket, double pulley_radius) {
  const double tip_y = value_or(bucket.has_tip_y_m(), bucket.tip_y_m(), 0.4);
  dda::Vec2 tip{value_or(bucket.has_tip_x_m(), bucket.tip_x_m(), -0.4), tip_y};
  if (bucket.has_opening_angle_deg())
    tip.x = -tip_y * std::tan(radians(bucket.opening_angle_deg()));
  switch (bucket.shape()) {
    case v1::Bucket::BEZIER:
      return dda::bezier_wall({bucket.x2_m(), bucket.x3_m(), bucket.x4_m()}, tip);
    case v1::Bucket::LOGARITHMIC:
      return dda::logarithmic_wall(tip, pulley_radius);
    case v1::Bucket::T_TYPE:
      return dda::t_type_wall(tip);
    case v1::Bucket::POLYLINE: {
      std::vector<dda::Vec2> wall;
      for (const v1::Point2& point : bucket.points()) wall.push_back(point_of(point));
      return wall;
    }
    default:
      return dda::straight_wall(tip);
  }
}

dda::BucketGeometry bucket_of(const v1::Discharge& d, double pulley_radius) {
  const v1::Bucket& bucket = d.bucket();
  const std::vector<dda::Vec2> outer = outer_wall(bucket, pulley_radius);
  const dda::InnerWall inner{
      .height = value_or(bucket.has_wall_height_m(), bucket.wall_height_m(), outer.back().y),
      .deflector = bucket.deflector_m(),
      .deflector_angle = radians(bucket.deflector_angle_deg())};
  return dda::make_bucket(outer, inner, pulley_radius);
}

DischargePlan::Filling filling_of(const v1::Discharge& d) {
  switch (d.filling()) {
    case v1::Discharge::ORDERED_COMPACT:
      return DischargePlan::Filling::ordered_compact;
    case v1::Discharge::STORED:
      return DischargePlan::Filling::stored;
    case v1::Discharge::EXPLICIT:
      return DischargePlan::Filling::placed;
    default:
      return DischargePlan::Filling::drop;
  }
}

dda::Disks disks_of(const v1::Discharge& d, double mass_per_area) {
  dda::Disks disks;
  for (const v1::Disc& disc : d.discs()) {
    const double radius = disc.diameter_m() / 2;
    disks.add({disc.x_m(), disc.y_m(), radius, 0},
              {disc.vx_m_per_s(), disc.vy_m_per_s(), radius * disc.spin_rad_per_s(),
               1 / (mass_per_area * pi * radius * radius)},
              0);
  }
  return disks;
}

void read_solver(const v1::Discharge& d, DischargePlan& plan) {
  if (d.solver().linear() == v1::Solver::PCG) plan.solver.linear = dda::LinearSolver::pcg;
  if (d.solver().integrator() == v1::Solver::NEWMARK_DDA)
    plan.solver.integrator = dda::Integrator::newmark_dda;
  if (d.solver().integrator() == v1::Solver::NEWMARK_TRAPEZOID)
    plan.solver.integrator = dda::Integrator::newmark_trapezoid;
  if (d.solver().method() != v1::Solver::OPEN_CLOSE) return;
  plan.solver.method = dda::SolverMethod::open_close;
  plan.penalty = {value_or(d.penalty().has_growth_factor(), d.penalty().growth_factor(), 1.25),
                  value_or(d.penalty().has_tolerance(), d.penalty().tolerance(), 0.01)};
}

dda::ContactEffects effects_of(const v1::Scene& scene) {
  const ContactEffectSet chosen = contact_effects(scene);
  return {.rotation = chosen.particle_rotation,
          .history = chosen.tangential_history,
          .cohesion = chosen.cohesion,
          .rolling = chosen.rolling_friction};
}

void read_contact(const v1::Scene& scene, double depth, DischargePlan& plan) {
  const v1::Discharge& d = scene.discharge();
  const double stiffness =
      value_or(d.penalty().has_stiffness_n_per_m(), d.penalty().stiffness_n_per_m(), 1e7);
  plan.contact = {.stiffness = depth * stiffness,
                  .friction_disks = std::tan(radians(d.friction_pp_deg())),
                  .friction_walls = std::tan(radians(d.friction_pw_deg())),
                  .restitution = d.normal_restitution(),
                  .rolling_friction = d.rolling_friction_coefficient(),
                  .cohesion = depth * d.cohesion_n_per_m(),
                  .effects = effects_of(scene)};
  plan.damping_rate = d.damping_per_s();
  plan.filling_stiffness =
      depth * value_or(d.has_filling_stiffness_n_per_m(), d.filling_stiffness_n_per_m(), stiffness);
  read_solver(d, plan);
  plan.solver.tolerance = value_or(d.solver().has_tolerance(), d.solver().tolerance(), 1e-2);
  plan.solver.max_sweeps = static_cast<std::uint32_t>(
      value_or(d.solver().has_max_iterations(), d.solver().max_iterations(), 500));
  plan.gravity = value_or(d.has_gravity_m_per_s2(), d.gravity_m_per_s2(), 9.81);
}

void read_disks(const v1::Scene& scene, double depth, DischargePlan& plan) {
  const v1::Discharge& d = scene.discharge();
  const v1::DiscParticles& particles = d.particles();
  const double mass_per_area = particles.density_kg_per_m3() * depth;
  plan.disk_kind = {
      .count = particles.count(),
      .diameter_min = particles.diameter_min_m(),
      .diameter_max = value_or(particles.has_diameter_max_m(), particles.diameter_max_m(),
                               particles.diameter_min_m()),
      .mass_per_area = mass_per_area,
      .seed = scene.has_seed() ? scene.seed() : 1};
  plan.filling = filling_of(d);
  if (plan.filling == DischargePlan::Filling::placed)
    plan.placed_disks = disks_of(d, mass_per_area);
}

void read_motion(const v1::Discharge& d, DischargePlan& plan) {
  plan.rotation_rate = d.rotation_rad_per_s();
  if (d.has_rademacher_ka()) plan.rademacher_ka = d.rademacher_ka();
  plan.run_up = d.run_up_m();
  plan.starts_with_belt_velocity = d.initial_velocity() == v1::Discharge::BELT || plan.run_up > 0;
  plan.time_step = value_or(d.has_time_step_s(), d.time_step_s(), 2e-4);
  plan.filling_time_step =
      value_or(d.has_filling_time_step_s(), d.filling_time_step_s(), plan.time_step);
  plan.end_angle = radians(value_or(d.has_end_angle_deg(), d.end_angle_deg(), 180));
  if (d.has_duration_s()) plan.duration = d.duration_s();
}

}  // namespace

DischargePlan make_discharge_plan(const v1::Scene& resolved) {
  if (!resolved.has_discharge()) throw std::invalid_argument("the scene is no discharge");
  if (const Status fits = check_contact_effects(resolved); !fits)
    throw std::invalid_argument(fits.error().message);
  const v1::Discharge& d = resolved.discharge();
  DischargePlan plan;
  const double depth =
      value_or(d.particles().has_axial_depth_m(), d.particles().axial_depth_m(), 1);
  plan.pulley_radius = value_or(d.has_pulley_radius_m(), d.pulley_radius_m(), 0.5);
  plan.axial_depth = depth;
  read_contact(resolved, depth, plan);
  read_disks(resolved, depth, plan);
  read_motion(d, plan);
  if (resolved.effects().gas() == v1::Effects::ON)
    plan.air =
        dda::StillAir{value_or(d.has_air_density_kg_per_m3(), d.air_density_kg_per_m3(), 1.2),
                      value_or(d.has_air_viscosity_pa_s(), d.air_viscosity_pa_s(), 1.81e-5),
                      d.particles().density_kg_per_m3()};
  for (const v1::Point2& point : d.target()) plan.target.push_back(point_of(point));
  if (!d.no_bucket()) plan.bucket = bucket_of(d, plan.pulley_radius);
  for (const v1::Wall2& wall : d.walls()) {
    std::vector<dda::Vec2> points;
    for (const v1::Point2& point : wall.points()) points.push_back(point_of(point));
    (wall.moves_with_bucket() ? plan.moving_walls : plan.fixed_walls).push_back(std::move(points));
  }
  return plan;
}

}  // namespace granary::scene
