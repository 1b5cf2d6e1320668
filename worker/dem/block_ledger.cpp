// Energy of the block engine. What contacts dissipate is summed in the kernels, every step; gravity
// and the centrifugal force have potentials, so their work over any span is a difference of
// potentials. Everything is taken at half steps, where the velocities live.
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/dem/block_engine.h"

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

Vec3 BlockEngine::half_step_position(std::size_t grain) const {
  const GrainMotion& m = motion_[grain];
  const double back = 0.5 * setup_.time_step;
  return {m.position[0] - back * m.velocity[0], m.position[1] - back * m.velocity[1],
          m.position[2] - back * m.velocity[2]};
}

double BlockEngine::kinetic_energy(std::size_t grain) const {
  const double* v = motion_[grain].velocity;
  const double* s = surface_[grain].speed;
  const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  const double turning = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];  // 1/2 I w^2 = 1/2 2/5 m (R w)^2
  return 0.5 * mass(grain) * (square + 0.4 * turning);
}

double BlockEngine::potential_energy(std::size_t grain) const {
  return -mass(grain) * dot(setup_.motion.gravity, half_step_position(grain));
}

double BlockEngine::centrifugal_potential(std::size_t grain) const {
  const Vec3 speed =
      cross(terms_.frame_omega(), half_step_position(grain) - setup_.motion.axis_point);
  return -0.5 * mass(grain) * dot(speed, speed);
}

// A free grain comes (sign +1) or goes (-1): what is stored changes as the channel does.
void BlockEngine::book_transfer(EnergyChannel channel, std::size_t grain, double sign) {
  book(channel, -sign * (kinetic_energy(grain) + potential_energy(grain)));
}

BlockEngine::Touch BlockEngine::touch_of_pair(std::size_t a, std::size_t b) const {
  const GrainMotion& ma = motion_[a];
  const GrainMotion& mb = motion_[b];
  const GrainSurface& sa = surface_[a];
  const GrainSurface& sb = surface_[b];
  const Vec3 apart{ma.position[0] - mb.position[0], ma.position[1] - mb.position[1],
                   ma.position[2] - mb.position[2]};
  const double distance = norm(apart);
  return {
      .normal = apart * (1 / distance),
      .overlap = sa.radius + sb.radius - distance,
      .velocity = {ma.velocity[0] - mb.velocity[0], ma.velocity[1] - mb.velocity[1],
                   ma.velocity[2] - mb.velocity[2]},
      .surface = {sa.speed[0] + sb.speed[0], sa.speed[1] + sb.speed[1], sa.speed[2] + sb.speed[2]},
      .laws = &laws_.pairs,
      .kind = class_[a] * setup_.classes.size() + class_[b]};
}

BlockEngine::Touch BlockEngine::touch_of_wall(std::size_t a, std::size_t wall) const {
  const GrainMotion& m = motion_[a];
  const GrainSurface& s = surface_[a];
  const Plane& plane = setup_.walls[wall];
  const Vec3 position{m.position[0], m.position[1], m.position[2]};
  return {.normal = plane.normal,
          .overlap = s.radius - dot(position - plane.point, plane.normal),
          .velocity = {m.velocity[0], m.velocity[1], m.velocity[2]},
          .surface = {s.speed[0], s.speed[1], s.speed[2]},
          .laws = &laws_.walls,
          .kind = class_[a]};
}

// Spring and attraction, which both have a potential [J].
double BlockEngine::normal_energy(const Touch& touch, double overlap) const {
  if (overlap <= 0) return 0;
  const double attraction =
      setup_.effects.cohesion ? touch.laws->cohesion[touch.kind] * overlap : 0;
  return 0.5 * touch.laws->normal_stiffness[touch.kind] * overlap * overlap - attraction;
}

// Of overlap and spring of the last step, carried on by half a step.
double BlockEngine::elastic_energy(const Touch& touch, const History& history) const {
  const double half_step = 0.5 * setup_.time_step;
  const double vn = dot(touch.velocity, touch.normal);
  const Vec3 velocity = touch.velocity + cross(touch.normal, touch.surface);
  const double overlap = touch.overlap + half_step * vn;
  const double normal = normal_energy(touch, overlap);
  if (!setup_.effects.tangential_history) return normal;
  const Vec3 spring = Vec3{history.spring[0], history.spring[1], history.spring[2]} +
                      (velocity - touch.normal * vn) * half_step;
  return normal + 0.5 * touch.laws->tangential_stiffness[touch.kind] * dot(spring, spring);
}

template <typename Visit>
void BlockEngine::visit_slots(Visit visit) const {
  for (std::size_t b = 0; b < block_count_; ++b) {
    const Block& block = blocks_[b];
    const auto place = [&](std::uint32_t offset) {
      return block.range.first + offset / sizeof(GrainSurface);
    };
    const SlotList& pairs = block.pair_slots;
    for (std::size_t slot = 0; slot < pairs.size(); ++slot) {
      const std::size_t first = place(pairs.first(slot)), second = place(pairs.second(slot));
      visit(pairs, slot, fresh_[first] != 0 || fresh_[second] != 0,
            [&] { return touch_of_pair(first, second); });
    }
    const SlotList& walls = block.wall_slots;
    for (std::size_t slot = 0; slot < walls.size(); ++slot) {
      const std::size_t first = place(walls.first(slot));
      visit(walls, slot, fresh_[first] != 0,
            [&] { return touch_of_wall(first, walls.second(slot)); });
    }
  }
}

// The kernels book half of a step's dissipation when they know where the step has led, one step
// later (book() in kernels_body.h). This is the half of the last step that is still to come.
BlockEngine::Unfinished BlockEngine::unfinished(const Touch& touch, const History& history) const {
  const Vec3 previous{history.velocity[0], history.velocity[1], history.velocity[2]};
  const Vec3 velocity = touch.velocity + cross(touch.normal, touch.surface);
  const double normal = dot(touch.velocity, touch.normal) * dot(previous, touch.normal);
  const double half_step = 0.5 * setup_.time_step;
  const double damping = half_step * touch.laws->normal_damping[touch.kind] * normal;
  const Vec3 sliding = velocity - touch.normal * dot(touch.velocity, touch.normal);
  const Vec3 force{history.spring[0], history.spring[1], history.spring[2]};
  const double friction = setup_.effects.tangential_history
                              ? half_step * touch.laws->tangential_damping[touch.kind] *
                                    (dot(velocity, previous) - normal)
                              : -half_step * dot(force, sliding);
  return {damping, friction};
}

// Of the moment: the deepest one so far may have parted since.
std::vector<std::int64_t> BlockEngine::deepest_ids() const {
  double deepest = 0;
  std::vector<std::int64_t> ids;
  const auto note = [&](double overlap, std::vector<std::int64_t> pair) {
    if (overlap <= deepest) return;
    deepest = overlap;
    ids = std::move(pair);
  };
  for (std::size_t b = 0; b < block_count_; ++b) {
    const Block& block = blocks_[b];
    const auto place = [&](std::uint32_t offset) {
      return block.range.first + offset / sizeof(GrainSurface);
    };
    for (std::size_t slot = 0; slot < block.pair_slots.size(); ++slot) {
      const std::size_t first = place(block.pair_slots.first(slot));
      const std::size_t second = place(block.pair_slots.second(slot));
      note(touch_of_pair(first, second).overlap, {id_[first], id_[second]});
    }
    for (std::size_t slot = 0; slot < block.wall_slots.size(); ++slot) {
      const std::size_t first = place(block.wall_slots.first(slot));
      note(touch_of_wall(first, block.wall_slots.second(slot)).overlap, {id_[first]});
    }
    for (const MeshContact& contact : block.mesh_contacts) {
      note(touch_of_mesh(contact).overlap, {id_[contact.grain]});
    }
  }
  return ids;
}

// Stored energy and unfinished dissipation of all contacts.
void BlockEngine::show_contacts(core::EnergyLedger& ledger) const {
  visit_slots([&](const SlotList& list, std::size_t slot, bool, auto touch) {
    if (!list.touching(slot)) return;
    const Touch contact = touch();
    ledger.elastic_j += elastic_energy(contact, list.history(slot));
    const Unfinished half = unfinished(contact, list.history(slot));
    ledger[EnergyChannel::normal_damping] += half.damping;
    ledger[EnergyChannel::friction] += half.friction;
  });
  show_mesh_contacts(ledger);
}

// Grains put in with an overlap bring its elastic energy along.
void BlockEngine::book_first_overlaps() {
  visit_slots([&](const SlotList& list, std::size_t slot, bool is_fresh, auto touch) {
    if (!is_fresh || list.touching(slot)) return;
    const Touch contact = touch();
    if (contact.overlap <= 0) return;
    const double overlap =
        contact.overlap + 0.5 * setup_.time_step * dot(contact.velocity, contact.normal);
    book(EnergyChannel::inlet, -normal_energy(contact, overlap));
  });
  book_first_mesh_overlaps();
  std::fill(fresh_.begin(), fresh_.end(), 0);
}

// ---------------------------------------------------------------------- spans between two orders

// Books what the blocks have gathered since the order was built; the set of grains is still the
// same.
void BlockEngine::flush_ledger() {
  for (std::size_t b = 0; b < block_count_; ++b) {
    Block& block = blocks_[b];
    book_block(block, ledger_);
    contact_evaluations_ += block.sums.contacts;
    block.sums = {};
    block.inlet_work = block.outlet_work = 0;
  }
  book_fields(ledger_);
}

void BlockEngine::book_block(const Block& block, core::EnergyLedger& ledger) {
  book_into(ledger, EnergyChannel::normal_damping, block.sums.normal_damping);
  book_into(ledger, EnergyChannel::friction, block.sums.friction);
  book_into(ledger, EnergyChannel::rolling, block.sums.rolling);
  book_into(ledger, EnergyChannel::inlet, -block.inlet_work);
  book_into(ledger, EnergyChannel::outlet, block.outlet_work);
}

// Work of gravity and of the centrifugal force since the order was built.
void BlockEngine::book_fields(core::EnergyLedger& ledger) const {
  const FieldEnergy now = field_energy(false);
  ledger.throughput_j += std::abs(now.potential - span_start_.potential);
  const double work = span_start_.centrifugal - now.centrifugal;
  ledger[EnergyChannel::frame_work] -= work;
  ledger.throughput_j += std::abs(work);
}

// Grains put in or set free since the order was built are not part of the span that began there.
BlockEngine::FieldEnergy BlockEngine::field_energy(bool with_fresh) const {
  FieldEnergy sum;
  const bool rotates = setup_.motion.rotates();
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    if (is_carried(k) || (!with_fresh && fresh_[k] != 0)) continue;
    sum.potential += potential_energy(k);
    if (rotates) sum.centrifugal += centrifugal_potential(k);
  }
  return sum;
}

void BlockEngine::begin_ledger_span() {
  span_start_ = field_energy(true);
}

const core::EnergyLedger& BlockEngine::ledger() const {
  shown_ledger_ = ledger_;
  for (std::size_t b = 0; b < block_count_; ++b) book_block(blocks_[b], shown_ledger_);
  book_fields(shown_ledger_);
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    if (is_carried(k)) continue;
    shown_ledger_.kinetic_j += kinetic_energy(k);
    shown_ledger_.potential_j += potential_energy(k);
  }
  show_contacts(shown_ledger_);
  return shown_ledger_;
}

}  // namespace granary::dem
