// Mesh walls in the block engine. Grains that may touch the mesh while the order lasts are listed
// with the triangles in their reach; their contacts are found and pushed one by one, in double.
// What is touched follows from positions alone, never from how long the lists are.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "worker/dem/block_engine.h"

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

namespace {

constexpr double kRounding = 1e-9;         // m, more than a sum of paths can lose
constexpr std::size_t kContactWidth = 10;  // normal, overlap, spring, velocity

Vec3 position_of(const GrainMotion& m) {
  return {m.position[0], m.position[1], m.position[2]};
}

// At least as long as the way of the last step.
double longest_path(const GrainMotion& m, double time_step) {
  return time_step * (std::abs(m.velocity[0]) + std::abs(m.velocity[1]) + std::abs(m.velocity[2]));
}

void append(std::vector<double>& values, const Vec3& v) {
  values.insert(values.end(), {v.x, v.y, v.z});
}

}  // namespace

std::vector<MeshLaw> BlockEngine::mesh_laws() const {
  std::vector<MeshLaw> laws;
  const PairCoefficients coefficients = pair_coefficients(setup_);
  for (std::size_t k = 0; k < setup_.classes.size(); ++k) {
    const GrainClass& grain_class = setup_.classes[k];
    const double response = grain_class.radius / grain_class.inertia();
    laws.push_back({coefficients.grain_wall[k], setup_.effects, setup_.effects.spin ? response : 0,
                    setup_.time_step});
  }
  return laws;
}

// Reaches over the path of the block's mean motion; what grains stray from it the skin allows for.
void BlockEngine::collect_mesh(Block& block) {
  block.mesh_rows.clear();
  block.near_triangles.clear();
  if (mesh_.empty()) return;
  const double longest = static_cast<double>(kLongestOrderInHorizons * horizon_) * setup_.time_step;
  const Vec3 half_path = block.mean_velocity * (0.5 * longest);
  for (std::uint32_t k = block.range.first; k < block.range.first + block.range.count; ++k) {
    if (is_carried(k)) continue;
    const auto begin = static_cast<std::uint32_t>(block.near_triangles.size());
    mesh_.add_near(position_of(motion_[k]) + half_path,
                   surface_[k].radius + skin_ + norm(half_path), block.near_triangles);
    const auto end = static_cast<std::uint32_t>(block.near_triangles.size());
    if (begin != end) block.mesh_rows.push_back({k, begin, end, 0});
  }
}

std::span<const std::uint32_t> BlockEngine::triangles_of(const Block& block, const MeshRow& row) {
  return std::span(block.near_triangles).subspan(row.begin, row.end - row.begin);
}

// Rows are passed over while their grain cannot have come to the nearest triangle; that saves time
// and changes no bit.
void BlockEngine::meet_mesh(Block& block, LineVector<GrainLoad>& desk) {
  std::swap(block.mesh_contacts, block.old_mesh_contacts);
  block.mesh_contacts.clear();
  const std::vector<MeshContact>& old = block.old_mesh_contacts;
  std::size_t at = 0;
  for (MeshRow& row : block.mesh_rows) {
    const std::size_t first = at;
    while (at < old.size() && old[at].grain == row.grain) ++at;
    const GrainMotion& motion = motion_[row.grain];
    row.room -= longest_path(motion, setup_.time_step);
    if (row.room > 0 && first == at) continue;
    const TouchList touches = mesh_.touches(position_of(motion), surface_[row.grain].radius,
                                            triangles_of(block, row), block.feet);
    row.room = touches.count == 0 ? touches.room - kRounding : 0;
    if (touches.count == 0 && first == at) continue;
    meet_row(block, row, std::span(old).subspan(first, at - first), touches, desk);
  }
}

void BlockEngine::meet_row(Block& block, const MeshRow& row, std::span<const MeshContact> known,
                           const TouchList& touches, LineVector<GrainLoad>& desk) {
  std::array<MeshContact, kMostTouches> slots;
  std::copy(known.begin(), known.end(), slots.begin());
  assign_touches(touches.all(), std::span<MeshContact>(slots));
  const MeshLaw& law = mesh_laws_[class_[row.grain]];
  const GrainMotion& motion = motion_[row.grain];
  const GrainSurface& surface = surface_[row.grain];
  for (MeshContact& slot : slots) {
    if (slot.is_met) {
      slot.grain = row.grain;
      push(slot, law, motion, surface, desk[row.grain - block.range.first], block.sums);
      block.mesh_contacts.push_back(slot);
    } else if (slot.touching) {
      part(slot, law, motion, surface, block.sums);
    }
  }
}

// As ends_at_outlet(), for a whole block.
void BlockEngine::end_mesh_at_outlet(Block& block) {
  const auto is_gone = [&](std::uint32_t grain) {
    return motion_[grain].position[0] > setup_.outlet_x;
  };
  std::erase_if(block.mesh_rows, [&](const MeshRow& row) { return is_gone(row.grain); });
  std::erase_if(block.mesh_contacts, [&](const MeshContact& contact) {
    if (!is_gone(contact.grain)) return false;
    const Touch touch = touch_of_mesh(contact);
    const Unfinished half = unfinished(touch, contact.history());
    block.outlet_work += elastic_energy(touch, contact.history());
    block.sums.normal_damping += half.damping;
    block.sums.friction += half.friction;
    return true;
  });
}

// --------------------------------------------------------------------------- between two orders

// Takes the contacts out of the blocks. Precondition: leavers are still there.
void BlockEngine::keep_mesh_contacts() {
  kept_mesh_contacts_.clear();
  for (std::size_t b = 0; b < block_count_; ++b) {
    const auto& contacts = blocks_[b].mesh_contacts;
    kept_mesh_contacts_.insert(kept_mesh_contacts_.end(), contacts.begin(), contacts.end());
    blocks_[b].mesh_contacts.clear();
  }
}

// `place`: where grains will be, ~0 for those that go.
void BlockEngine::move_mesh_contacts(std::span<const std::uint32_t> place) {
  std::erase_if(kept_mesh_contacts_, [&](const MeshContact& contact) {
    if (place[contact.grain] != ~0U) return false;
    const Touch touch = touch_of_mesh(contact);
    const Unfinished half = unfinished(touch, contact.history());
    book(EnergyChannel::outlet, elastic_energy(touch, contact.history()));
    book(EnergyChannel::normal_damping, half.damping);
    book(EnergyChannel::friction, half.friction);
    return true;
  });
  for (MeshContact& contact : kept_mesh_contacts_) contact.grain = place[contact.grain];
  std::stable_sort(kept_mesh_contacts_.begin(), kept_mesh_contacts_.end(),
                   [](const MeshContact& l, const MeshContact& r) { return l.grain < r.grain; });
}

void BlockEngine::inherit_mesh_contacts(Block& block) {
  const auto before = [](const MeshContact& contact, std::uint32_t grain) {
    return contact.grain < grain;
  };
  const auto begin = std::lower_bound(kept_mesh_contacts_.begin(), kept_mesh_contacts_.end(),
                                      block.range.first, before);
  const auto end = std::lower_bound(begin, kept_mesh_contacts_.end(),
                                    block.range.first + block.range.count, before);
  block.mesh_contacts.assign(begin, end);
}

// ----------------------------------------------------------------------------------------- energy

// The grain has moved on since; the mesh has not.
BlockEngine::Touch BlockEngine::touch_of_mesh(const MeshContact& contact) const {
  const GrainMotion& m = motion_[contact.grain];
  const GrainSurface& s = surface_[contact.grain];
  const Vec3 velocity{m.velocity[0], m.velocity[1], m.velocity[2]};
  return {.normal = contact.touch.normal,
          .overlap = contact.touch.overlap - setup_.time_step * dot(velocity, contact.touch.normal),
          .velocity = velocity,
          .surface = {s.speed[0], s.speed[1], s.speed[2]},
          .laws = &laws_.walls,
          .kind = class_[contact.grain]};
}

void BlockEngine::show_mesh_contacts(core::EnergyLedger& ledger) const {
  for (std::size_t b = 0; b < block_count_; ++b) {
    for (const MeshContact& contact : blocks_[b].mesh_contacts) {
      const Touch touch = touch_of_mesh(contact);
      const Unfinished half = unfinished(touch, contact.history());
      ledger.elastic_j += elastic_energy(touch, contact.history());
      ledger[EnergyChannel::normal_damping] += half.damping;
      ledger[EnergyChannel::friction] += half.friction;
    }
  }
}

// Grains put in with an overlap bring its elastic energy along.
void BlockEngine::book_first_mesh_overlaps() {
  for (std::size_t b = 0; b < block_count_; ++b) {
    Block& block = blocks_[b];
    for (const MeshRow& row : block.mesh_rows) {
      if (fresh_[row.grain] == 0) continue;
      const TouchList touches =
          mesh_.touches(position_of(motion_[row.grain]), surface_[row.grain].radius,
                        triangles_of(block, row), block.feet);
      const double* v = motion_[row.grain].velocity;
      for (const SurfaceTouch& found : touches.all()) {
        Touch touch;
        touch.laws = &laws_.walls;
        touch.kind = class_[row.grain];
        const double approach = dot(Vec3{v[0], v[1], v[2]}, found.normal);
        const double overlap = found.overlap + 0.5 * setup_.time_step * approach;
        book(EnergyChannel::inlet, -normal_energy(touch, overlap));
      }
    }
  }
}

// ------------------------------------------------------------------------------------ checkpoints

void BlockEngine::save_mesh(core::State& state) const {
  if (mesh_.empty()) return;
  std::vector<std::uint32_t> rows, triangles, grains;
  std::vector<double> contacts;
  for (std::size_t b = 0; b < block_count_; ++b) {
    const Block& block = blocks_[b];
    for (const MeshRow& row : block.mesh_rows) {
      rows.insert(rows.end(), {row.grain, row.end - row.begin});
      const auto near = triangles_of(block, row);
      triangles.insert(triangles.end(), near.begin(), near.end());
    }
    for (const MeshContact& contact : block.mesh_contacts) {
      grains.push_back(contact.grain);
      append(contacts, contact.touch.normal);
      contacts.push_back(contact.touch.overlap);
      append(contacts, contact.spring);
      append(contacts, contact.velocity);
    }
  }
  state.put("dem.mesh_rows", "1", rows, 2);
  state.put("dem.mesh_triangles", "1", triangles);
  state.put("dem.mesh_contact_grain", "1", grains);
  state.put("dem.mesh_contacts", "SI", contacts, kContactWidth);
}

void BlockEngine::load_mesh(const core::State& state) {
  if (mesh_.empty()) return;
  const auto rows = state.get<std::uint32_t>("dem.mesh_rows");
  const auto triangles = state.get<std::uint32_t>("dem.mesh_triangles");
  const auto grains = state.get<std::uint32_t>("dem.mesh_contact_grain");
  const auto contacts = state.get<double>("dem.mesh_contacts");
  if (contacts.size() != kContactWidth * grains.size()) {
    throw std::runtime_error("state: mesh contacts differ in length");
  }
  kept_mesh_contacts_.clear();
  for (std::size_t k = 0; k < grains.size(); ++k) {
    const double* c = &contacts[kContactWidth * k];
    kept_mesh_contacts_.push_back({.grain = grains[k],
                                   .touch = {{c[0], c[1], c[2]}, c[3]},
                                   .spring = {c[4], c[5], c[6]},
                                   .velocity = {c[7], c[8], c[9]},
                                   .touching = true});
  }
  std::size_t row = 0, used = 0;
  for (Block& block : blocks_) {
    inherit_mesh_contacts(block);
    const std::uint32_t end = block.range.first + block.range.count;
    for (; 2 * row < rows.size() && rows[2 * row] < end; ++row) {
      const std::uint32_t count = rows[2 * row + 1];
      if (used + count > triangles.size()) throw std::runtime_error("state: mesh rows");
      const auto begin = static_cast<std::uint32_t>(block.near_triangles.size());
      for (std::uint32_t k = 0; k < count; ++k) {
        if (triangles[used] >= setup_.triangles.size()) {
          throw std::runtime_error("state: triangle that the scene does not have");
        }
        block.near_triangles.push_back(triangles[used++]);
      }
      block.mesh_rows.push_back({rows[2 * row], begin, begin + count, 0});
    }
  }
}

}  // namespace granary::dem
