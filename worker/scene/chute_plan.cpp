#include "worker/scene/chute_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>

#include "proto/contract/chute_rules.h"

namespace granary::scene {
namespace {

using core::Vec3;

constexpr double kDegree = std::numbers::pi / 180;
// Replicates of one scene must not be the same run: entering grains spin a little at random, with
// surface speeds of this share of the inlet speed.
constexpr double kSpinNoise = 1e-3;

Error refuse(const std::string& path, const std::string& what) {
  return {ErrorCode::invalid_argument, path + ": " + what, path};
}

Error not_built(const std::string& path) {
  return {ErrorCode::unimplemented, path + ": not available in this version", path};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

dem::ContactParameters contact(const v1::Contact& c) {
  return {.normal_stiffness = c.normal_stiffness_n_per_m(),
          .normal_restitution = c.normal_restitution(),
          .tangential_restitution = c.tangential_restitution(),
          .friction = c.friction_coefficient(),
          .rolling_friction = c.rolling_friction_coefficient(),
          .tangential_stiffness = 0};
}

bool is_on(v1::Effects::Mode mode) {
  return mode != v1::Effects::OFF;
}

// PHYSICS section H1: the axis is vertical, rotation_rpm > 0 points down.
dem::Motion motion_of(const v1::Scene& scene) {
  const v1::Chute& chute = scene.chute();
  const double slope = chute.inclination_deg() * kDegree;
  const Vec3 down{std::sin(slope), 0, -std::cos(slope)};
  dem::Motion motion;
  motion.gravity = down * chute.gravity_m_per_s2();
  if (is_on(scene.effects().rotating_frame())) {
    motion.omega = down * (chute.rotation_rpm() * 2 * std::numbers::pi / 60);
  }
  motion.axis_point = {chute.axis_offset_m(), 0.5 * chute.width_m(), 0};
  motion.frame =
      chute.frame() == v1::Chute::INERTIAL ? dem::FrameKind::inertial : dem::FrameKind::corotating;
  return motion;
}

std::vector<dem::Plane> walls_of(const v1::Chute& chute) {
  std::vector<dem::Plane> walls;
  if (!chute.no_walls()) {
    walls.push_back({{0, 0, 0}, {0, 0, 1}});
    walls.push_back({{0, 0, 0}, {0, 1, 0}});
    walls.push_back({{0, chute.width_m(), 0}, {0, -1, 0}});
  }
  if (chute.closed_end()) {
    walls.push_back({{chute.length_m(), 0, 0}, {-1, 0, 0}});
    if (chute.inlet().feed() == v1::Inlet::NONE) walls.push_back({{0, 0, 0}, {1, 0, 0}});
  }
  for (const v1::WallPlane& plane : chute.planes()) {
    const Vec3 normal{plane.normal(0), plane.normal(1), plane.normal(2)};
    const double length = norm(normal);
    walls.push_back({{plane.point_m(0), plane.point_m(1), plane.point_m(2)},
                     length > 0 ? normal * (1 / length) : normal});
  }
  return walls;
}

std::vector<dem::Triangle> triangles_of(const v1::Chute& chute) {
  std::vector<dem::Triangle> triangles;
  for (const v1::Triangle& triangle : chute.triangles()) {
    const auto& v = triangle.vertices_m();
    triangles.push_back({{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}});
  }
  return triangles;
}

// Where grains leave. A chute made of triangles alone still ends at its length when it is fed.
double outlet_of(const v1::Chute& chute) {
  const bool is_fed_mesh = chute.triangles_size() > 0 && chute.inlet().feed() != v1::Inlet::NONE;
  const bool is_open = !chute.closed_end() && (!chute.no_walls() || is_fed_mesh);
  return is_open ? chute.length_m() : std::numeric_limits<double>::infinity();
}

std::vector<dem::Grain> beads_of(const v1::Chute& chute) {
  std::vector<dem::Grain> beads;
  for (const v1::Bead& b : chute.beads()) {
    dem::Grain grain;
    grain.position = {b.x_m(), b.y_m(), b.z_m()};
    grain.velocity = {b.vx_m_per_s(), b.vy_m_per_s(), b.vz_m_per_s()};
    grain.spin = {b.spin_x_rad_per_s(), b.spin_y_rad_per_s(), b.spin_z_rad_per_s()};
    grain.grain_class = static_cast<std::uint8_t>(b.particle_class());
    beads.push_back(grain);
  }
  return beads;
}

dem::LatticeFeedSetup feed_of(const v1::Scene& scene, const ChutePlan& plan) {
  const v1::Inlet& inlet = scene.chute().inlet();
  dem::LatticeFeedSetup feed;
  feed.width = plan.geometry.width;
  feed.sluice_height = inlet.sluice_height_m();
  feed.mass_flow = inlet.mass_flow_kg_per_s();
  feed.classes = plan.engine.classes;
  feed.mass_fractions = plan.mass_fractions;
  if (inlet.spin() == v1::Inlet::LABORATORY) feed.spin = -plan.engine.motion.omega;
  feed.jitter = inlet.jitter();
  feed.spin_noise = kSpinNoise;
  feed.seed = plan.seed;
  return feed;
}

// ------------------------------------------------------------- what the contract cannot know

std::optional<Error> check_step(const ChutePlan& plan) {
  const double limit = dem::stable_time_step(plan.engine);
  if (plan.engine.time_step > 0 && plan.engine.time_step <= limit) return {};
  return refuse("chute.time_step_s", "= " + number(plan.engine.time_step) +
                                         " s is unstable, must be > 0 and <= " + number(limit) +
                                         " s = 2 / sqrt(12 k_n / m) of the lightest grain");
}

std::optional<Error> check_contact(const dem::ContactParameters& c, const std::string& path) {
  if (c.friction < 0 || c.rolling_friction < 0) {
    return refuse(path + ".friction_coefficient", "must be >= 0, as must rolling friction");
  }
  if (c.normal_restitution < 0 || c.normal_restitution > 1 || c.tangential_restitution < 0 ||
      c.tangential_restitution > 1) {
    return refuse(path + ".normal_restitution", "restitution must be within 0 .. 1");
  }
  if (c.normal_stiffness <= 0) return refuse(path + ".normal_stiffness_n_per_m", "must be > 0");
  return {};
}

std::optional<Error> check_plan(const ChutePlan& plan) {
  if (auto error = check_contact(plan.engine.grain_grain, "chute.contact_pp")) return error;
  if (auto error = check_contact(plan.engine.grain_wall, "chute.contact_pw")) return error;
  return check_step(plan);
}

}  // namespace

Result<ChutePlan> plan_chute(const v1::Scene& scene) {
  if (!scene.has_chute()) return refuse("chute", "is missing: the scene is no chute");
  if (scene.effects().gas() == v1::Effects::ON) return not_built("effects.gas");
  if (auto error = check_resolved_chute(scene.chute())) return *error;
  const v1::Chute& chute = scene.chute();
  ChutePlan plan;
  plan.geometry = {chute.length_m(), chute.width_m()};
  for (const v1::SphereClass& c : chute.particles()) {
    plan.engine.classes.push_back({0.5 * c.diameter_m(), c.density_kg_per_m3()});
    plan.mass_fractions.push_back(c.mass_fraction());
  }
  if (plan.engine.classes.empty()) return refuse("chute.particles", "needs at least one class");
  plan.engine.grain_grain = contact(chute.contact_pp());
  plan.engine.grain_wall = contact(chute.contact_pw());
  plan.engine.effects = {
      .tangential_history = is_on(scene.effects().tangential_history()),
      .rolling_friction = is_on(scene.effects().rolling_friction()),
      .spin = is_on(scene.effects().particle_rotation()),
      .cohesion = is_on(scene.effects().cohesion()) && chute.cohesion_bond() > 0};
  plan.engine.grain_grain.cohesion_bond = chute.cohesion_bond();
  plan.engine.grain_wall.cohesion_bond = chute.cohesion_bond();
  plan.engine.damping = chute.damping() == v1::Chute::PREDICTED_VELOCITY
                            ? dem::Damping::predicted_velocity
                            : dem::Damping::semi_implicit;
  plan.engine.walls = walls_of(chute);
  plan.engine.triangles = triangles_of(chute);
  plan.engine.motion = motion_of(scene);
  plan.engine.time_step = chute.time_step_s();
  plan.engine.precision =
      chute.precision() == v1::Chute::DOUBLE ? dem::Precision::full : dem::Precision::mixed;
  plan.engine.threads = scene.has_threads() ? scene.threads() : 1;
  plan.engine.outlet_x = outlet_of(chute);
  plan.beads = beads_of(chute);
  plan.initial_count = chute.initial_count();
  if (chute.inlet().feed() == v1::Inlet::HOPPER) {
    plan.hopper = hopper_of(chute);
    plan.initial_count = hopper_grain_count(chute);
    plan.engine.walls.push_back(plan.hopper->back);
    const std::vector<dem::Triangle>& gate = plan.hopper->gate;
    plan.engine.triangles.insert(plan.engine.triangles.end(), gate.begin(), gate.end());
  }
  plan.seed = scene.seed();
  plan.duration = chute.duration_s();
  plan.sample_start = chute.sample_start_s();
  plan.sample_interval = chute.sample_interval_s() > 0 ? chute.sample_interval_s() : 0.01;
  if (chute.inlet().feed() == v1::Inlet::LATTICE && chute.inlet().mass_flow_kg_per_s() > 0) {
    plan.feed = feed_of(scene, plan);
  }
  if (auto error = check_plan(plan)) return *error;
  return plan;
}

}  // namespace granary::scene
