#include "worker/dda/narrow_phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granary::dda {
namespace {

// Slower approaches than this do not bounce: below it resting contacts would chatter.
constexpr double kRestitutionThreshold = 0.02;  // m/s; a fall of 0.02 mm
constexpr std::uint32_t kMostSmallSteps = 200;
// A step begins with the springs' forces alone, without those of the dashpots, and new normals.
// What its first small step misses must be made up before the next step: with one small step a bed
// of soft disks rattles at 0.04 m/s for ever, with two it settles, with three as fast as with many.
constexpr std::uint32_t kFewestSmallSteps = 3;
// Bridges between disks break at this gap / mean diameter. Well below the speculative margin, so
// that every bridge is among the contacts of a step.
constexpr double kCohesionRange = 0.01;

// Damping ratio of the dashpot with which a spring contact rebounds with e (PHYSICS section A1).
double damping_ratio(double restitution) {
  if (restitution <= 0) return 1;
  const double log_e = std::log(restitution);
  return -log_e / std::sqrt(std::numbers::pi * std::numbers::pi + log_e * log_e);
}

// Steps h with kappa = K h^2 / m at most the setting.
std::uint32_t small_step_count(const System& system) {
  if (!takes_small_steps(system)) return 1;
  const double kappa =
      system.contact.stiffness * system.time_step * system.time_step / system.mean_mass;
  const double count = std::ceil(std::sqrt(kappa / system.solver.small_step_kappa));
  return static_cast<std::uint32_t>(std::clamp<double>(count, kFewestSmallSteps, kMostSmallSteps));
}

CandidateArrays arrays_of(const CandidateList& list) {
  return {list.first.data(),        list.second.data(),
          list.normal_force.data(), list.tangential_force.data(),
          list.colour_start.data(), list.colour_start.size() - 1};
}

double weight_n_of(const ContactTerms& terms, double inverse_mass) {
  return terms.relaxation / (inverse_mass + terms.compliance_n);
}

double weight_t_of(const ContactTerms& terms, double inverse_mass) {
  return terms.relaxation / ((1 + terms.spin_factor) * inverse_mass + terms.compliance_t);
}

struct WallStep {
  RigidPose start, end;  // bucket
};

void append_wall_contact(System& system, const ContactTerms& terms, const WallStep& walls,
                         std::size_t slot) {
  const CandidateList& list = system.lists.walls;
  const std::int32_t disk = list.first[slot];
  const DiskPose& pose = system.disks.pose[static_cast<std::size_t>(disk)];
  const DiskMotion& motion = system.disks.motion[static_cast<std::size_t>(disk)];
  const bool moves = system.walls.segments[static_cast<std::size_t>(list.second[slot])].moves;
  const RigidPose start = moves ? walls.start : RigidPose{};
  const RigidPose end = moves ? walls.end : RigidPose{};
  const Vec2 velocity{motion.vx, motion.vy};
  const Vec2 centre{pose.x, pose.y};
  const auto touch = touch_segment(system.walls.segments, list.second[slot], start.to_body(centre),
                                   end.to_body(centre + terms.time_step * velocity), pose.radius);
  const double force = list.normal_force[slot], margin_ratio = system.solver.margin_ratio;
  if (!touch ||
      !(std::min(touch->gap_start, touch->gap_end) < margin_ratio * pose.radius || force != 0))
    return;

  const Vec2 normal = end.turn(touch->normal), tangent{-normal.y, normal.x};
  const Vec2 wall_velocity =
      (1 / terms.time_step) * (end.to_world(touch->point) - start.to_world(touch->point));
  const double approach = dot(normal, wall_velocity - velocity);
  const double gap_linear = touch->gap_end + terms.time_step * dot(normal, velocity) -
                            terms.time_step * dot(normal, wall_velocity);
  const bool bounces = approach < -terms.restitution_threshold && touch->gap_end < 0;
  double bias = gap_linear / terms.time_step + dot(normal, wall_velocity);
  if (terms.restitution > 0 && bounces)
    bias = std::min(bias, dot(normal, wall_velocity) + terms.restitution * approach);

  ActiveContacts& out = system.wall_contacts;
  const std::size_t k = out.size++;
  const double stored = list.tangential_force[slot];
  out.first[k] = disk;
  out.second[k] = system.disks.rest_index();
  out.slot[k] = static_cast<std::int32_t>(slot);
  out.normal_x[k] = normal.x;
  out.normal_y[k] = normal.y;
  out.bias_n[k] = bias;
  out.bias_t[k] = dot(tangent, wall_velocity) - terms.compliance * terms.small_step * stored;
  out.weight_n[k] = weight_n_of(terms, motion.inverse_mass);
  out.weight_t[k] = weight_t_of(terms, motion.inverse_mass);
  out.impulse_n[k] = terms.small_step * force;
  out.impulse_t[k] = terms.small_step * stored;
  out.gap_start[k] = touch->gap_start;
  out.stored_t[k] = stored;
  out.gap_linear[k] = gap_linear;
  out.offset_t[k] = out.curvature[k] = 0;
  out.rebound[k] = bounces && force <= 0 ? -terms.restitution * approach : kNoRebound;
  out.group_rebounds[k / kGroupSize] |= out.rebound[k] != kNoRebound;
  out.drift_n[k] = dot(normal, wall_velocity);
  out.drift_t[k] = dot(tangent, wall_velocity);
  system.wall_velocity[k] = wall_velocity;
  system.touched[static_cast<std::size_t>(disk)] = 1;
  ++out.contact_count;
}

void pad_walls(System& system) {
  ActiveContacts& out = system.wall_contacts;
  const std::int32_t rest = system.disks.rest_index();
  for (; out.size % kGroupSize != 0; ++out.size) {
    const std::size_t k = out.size;
    out.first[k] = out.second[k] = rest;
    out.slot[k] = -1;
    out.normal_x[k] = out.bias_n[k] = out.gap_start[k] = 1;
    out.normal_y[k] = out.bias_t[k] = out.weight_n[k] = out.weight_t[k] = 0;
    out.impulse_n[k] = out.impulse_t[k] = out.stored_t[k] = 0;
    out.gap_linear[k] = 1;
    out.offset_t[k] = out.curvature[k] = out.drift_n[k] = out.drift_t[k] = 0;
    out.rebound[k] = kNoRebound;
    system.wall_velocity[k] = {};
  }
}

void select_walls(System& system, const ContactTerms& terms) {
  const CandidateList& list = system.lists.walls;
  ActiveContacts& out = system.wall_contacts;
  out.reserve(list.size());
  system.wall_velocity.resize(out.first.size());
  out.size = out.contact_count = 0;
  std::fill(out.group_rebounds.begin(), out.group_rebounds.end(), std::uint8_t{0});
  const WallStep walls{system.bucket_pose(system.time),
                       system.bucket_pose(system.time + system.time_step)};
  for (std::size_t colour = 0; colour + 1 < list.colour_start.size(); ++colour) {
    for (std::size_t s = list.colour_start[colour]; s < list.colour_start[colour + 1]; ++s)
      if (list.first[s] != system.disks.rest_index()) append_wall_contact(system, terms, walls, s);
    pad_walls(system);
  }
}

// Arms, weights and warm start of the rolling resistance of one list. `wall_spin`: of its walls
// that move with the bucket [rad/s].
void arm_list(const System& system, const CandidateList& list, const ContactTerms& terms,
              double wall_spin, ActiveContacts& out) {
  const bool walls = &list == &system.lists.walls;
  out.reserve_rolling();
  for (std::size_t k = 0; k < out.size; ++k) {
    out.arm_first[k] = out.arm_second[k] = out.weight_r[k] = 0;
    out.impulse_r[k] = out.drift_r[k] = out.rolled[k] = 0;
    if (out.slot[k] < 0) continue;
    const auto slot = static_cast<std::size_t>(out.slot[k]);
    const auto first = static_cast<std::size_t>(out.first[k]);
    const auto second = static_cast<std::size_t>(out.second[k]);
    const double r1 = system.disks.pose[first].radius, r2 = system.disks.pose[second].radius;
    const double arm = walls ? r1 : 2 * r1 * r2 / (r1 + r2);
    out.arm_first[k] = arm / r1;
    if (!walls) out.arm_second[k] = arm / r2;
    if (walls && system.walls.segments[static_cast<std::size_t>(list.second[slot])].moves)
      out.drift_r[k] = arm * wall_spin;
    const double mobility =
        terms.spin_factor *
        (system.disks.motion[first].inverse_mass * out.arm_first[k] * out.arm_first[k] +
         system.disks.motion[second].inverse_mass * out.arm_second[k] * out.arm_second[k]);
    out.weight_r[k] = terms.relaxation / mobility;
    out.impulse_r[k] = terms.small_step * list.rolling_force[slot];
  }
}

void arm_rolling(System& system) {
  arm_list(system, system.lists.pairs, pair_terms(system), 0, system.pair_contacts);
  arm_list(system, system.lists.walls, wall_terms(system), system.bucket_velocity().turn_rate,
           system.wall_contacts);
}

}  // namespace

bool takes_small_steps(const System& system) {
  return system.solver.small_step_kappa > 0 && system.solver.method == SolverMethod::impulse &&
         system.solver.integrator == Integrator::backward_euler;
}

ContactTerms contact_terms(const System& system, double friction, double reduced_mass) {
  const double dt = system.time_step, stiffness = system.contact.stiffness;
  const std::uint32_t count = small_step_count(system);
  const double h = dt / count;
  const bool small_steps = takes_small_steps(system);
  const ContactEffects& effects = system.contact.effects;
  const double spin_factor = effects.rotation ? 2.0 : 0.0;
  const double ratio = small_steps ? damping_ratio(system.contact.restitution) : 0;
  const double damping_n = 2 * ratio * std::sqrt(stiffness * reduced_mass);
  const double damping_t = effects.history ? damping_n / std::sqrt(1 + spin_factor) : 0;
  return {.time_step = dt,
          .small_step = h,
          .stiffness = stiffness,
          .damping_n = damping_n,
          .damping_t = damping_t,
          .compliance = 1 / (stiffness * h * h),
          .compliance_n = 1 / (stiffness * h * h + damping_n * h),
          .compliance_t = effects.history ? 1 / (stiffness * h * h + damping_t * h) : 0,
          .friction = friction,
          .rolling = system.contact.rolling_friction,
          .cohesion = system.contact.cohesion,
          .cohesion_range = 2 * kCohesionRange * system.mean_radius,
          .spin_factor = spin_factor,
          .relaxation = small_steps ? 1.0 : system.solver.relaxation,
          .weight_n = 0,
          .weight_t = 0,
          .normal_time = small_steps ? dt / 2 : dt,
          .restitution = system.contact.restitution,
          .restitution_threshold = kRestitutionThreshold};
}

// Where all disks have one mass, `disks` of them at a contact, small steps need not load weights.
ContactTerms with_one_weight(const System& system, ContactTerms terms, int disks) {
  if (!takes_small_steps(system) || !system.one_mass) return terms;
  const double inverse_mass = disks * system.disks.motion[0].inverse_mass;
  terms.weight_n = weight_n_of(terms, inverse_mass);
  terms.weight_t = weight_t_of(terms, inverse_mass);
  return terms;
}

ContactTerms pair_terms(const System& system) {
  const ContactTerms terms =
      contact_terms(system, system.contact.friction_disks, system.mean_mass / 2);
  return with_one_weight(system, terms, 2);
}

ContactTerms wall_terms(const System& system) {
  const ContactTerms terms = contact_terms(system, system.contact.friction_walls, system.mean_mass);
  return with_one_weight(system, terms, 1);
}

ContactArrays arrays_of(ActiveContacts& c) {
  return {c.first.data(),      c.second.data(),     c.slot.data(),           c.normal_x.data(),
          c.normal_y.data(),   c.bias_n.data(),     c.bias_t.data(),         c.weight_n.data(),
          c.weight_t.data(),   c.impulse_n.data(),  c.impulse_t.data(),      c.gap_start.data(),
          c.stored_t.data(),   c.gap_linear.data(), c.offset_t.data(),       c.curvature.data(),
          c.gap_now.data(),    c.stick_t.data(),    c.slide_t.data(),        c.rebound.data(),
          c.drift_n.data(),    c.drift_t.data(),    c.group_rebounds.data(), c.arm_first.data(),
          c.arm_second.data(), c.weight_r.data(),   c.impulse_r.data(),      c.rolled.data(),
          c.drift_r.data()};
}

void select_contacts(System& system) {
  std::fill(system.touched.begin(), system.touched.end(), std::uint8_t{0});
  const double dt = system.time_step, widened = 1 + system.solver.margin_ratio;
  const std::size_t count = system.disks.count();
  system.ahead.resize(count + 1);
  for (std::size_t k = 0; k < count; ++k) {
    const DiskPose& p = system.disks.pose[k];
    const DiskMotion& v = system.disks.motion[k];
    system.ahead[k] = {p.x + dt * v.vx, p.y + dt * v.vy, widened * p.radius, 0};
  }
  system.ahead[count] = system.disks.pose[count];
  ActiveContacts& pairs = system.pair_contacts;
  pairs.reserve(system.lists.pairs.size());
  system.picked.resize(system.lists.pairs.size() + kGroupSize);
  pairs.size = kernels().select_pairs(
      arrays_of(system.lists.pairs), system.disks.pose.data(), system.disks.motion.data(),
      system.ahead.data(), system.disks.rest_index(), pair_terms(system), arrays_of(pairs),
      system.touched.data(), system.picked.data(), &pairs.contact_count);
  select_walls(system, wall_terms(system));
  if (system.contact.effects.rolling) arm_rolling(system);
  system.report.contacts = pairs.contact_count + system.wall_contacts.contact_count;
}

}  // namespace granary::dda
