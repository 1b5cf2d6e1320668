#include "worker/dda/narrow_phase.h"

#include <algorithm>

namespace granary::dda {
namespace {

// Slower approaches than this do not bounce: below it resting contacts would chatter.
constexpr double kRestitutionThreshold = 0.02;  // m/s; a fall of 0.02 mm

CandidateArrays arrays_of(const CandidateList& list) {
  return {list.first.data(),        list.second.data(),
          list.normal_force.data(), list.tangential_force.data(),
          list.colour_start.data(), list.colour_start.size() - 1};
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
  const double force = list.normal_force[slot];
  if (!touch ||
      !(std::min(touch->gap_start, touch->gap_end) < terms.margin_ratio * pose.radius || force > 0))
    return;

  const Vec2 normal = end.turn(touch->normal), tangent{-normal.y, normal.x};
  const Vec2 wall_velocity =
      (1 / terms.time_step) * (end.to_world(touch->point) - start.to_world(touch->point));
  const double approach = dot(normal, wall_velocity - velocity);
  double bias = touch->gap_end / terms.time_step + dot(normal, velocity);
  if (terms.restitution > 0 && approach < -terms.restitution_threshold && touch->gap_end < 0)
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
  out.bias_t[k] = dot(tangent, wall_velocity) - terms.compliance * terms.time_step * stored;
  out.weight_n[k] = terms.relaxation / (motion.inverse_mass + terms.compliance);
  out.weight_t[k] =
      terms.relaxation / ((1 + terms.spin_factor) * motion.inverse_mass + terms.compliance);
  out.impulse_n[k] = terms.time_step * force;
  out.impulse_t[k] = terms.time_step * stored;
  out.gap_start[k] = touch->gap_start;
  out.stored_t[k] = stored;
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
    system.wall_velocity[k] = {};
  }
}

void select_walls(System& system, const ContactTerms& terms) {
  const CandidateList& list = system.lists.walls;
  ActiveContacts& out = system.wall_contacts;
  out.reserve(list.size());
  system.wall_velocity.resize(out.first.size());
  out.size = out.contact_count = 0;
  const WallStep walls{system.bucket_pose(system.time),
                       system.bucket_pose(system.time + system.time_step)};
  for (std::size_t colour = 0; colour + 1 < list.colour_start.size(); ++colour) {
    for (std::size_t s = list.colour_start[colour]; s < list.colour_start[colour + 1]; ++s)
      if (list.first[s] != system.disks.rest_index()) append_wall_contact(system, terms, walls, s);
    pad_walls(system);
  }
}

}  // namespace

ContactTerms contact_terms(const System& system, double friction) {
  const double dt = system.time_step;
  return {.time_step = dt,
          .compliance = 1 / (system.contact.stiffness * dt * dt),
          .friction = friction,
          .spin_factor = system.contact.rotation ? 2.0 : 0.0,
          .relaxation = system.solver.relaxation,
          .margin_ratio = system.solver.margin_ratio,
          .restitution = system.contact.restitution,
          .restitution_threshold = kRestitutionThreshold};
}

ContactArrays arrays_of(ActiveContacts& c) {
  return {c.first.data(),    c.second.data(),    c.slot.data(),      c.normal_x.data(),
          c.normal_y.data(), c.bias_n.data(),    c.bias_t.data(),    c.weight_n.data(),
          c.weight_t.data(), c.impulse_n.data(), c.impulse_t.data(), c.gap_start.data(),
          c.stored_t.data()};
}

void select_contacts(System& system) {
  std::fill(system.touched.begin(), system.touched.end(), std::uint8_t{0});
  const ContactTerms pair_terms = contact_terms(system, system.contact.friction_disks);
  ActiveContacts& pairs = system.pair_contacts;
  pairs.reserve(system.lists.pairs.size());
  pairs.size =
      kernels().select_pairs(arrays_of(system.lists.pairs), system.disks.pose.data(),
                             system.disks.motion.data(), system.disks.rest_index(), pair_terms,
                             arrays_of(pairs), system.touched.data(), &pairs.contact_count);
  select_walls(system, contact_terms(system, system.contact.friction_walls));
  system.report.contacts = pairs.contact_count + system.wall_contacts.contact_count;
}

}  // namespace granary::dda
