// Snapshot and restore of the plain engine. Candidate lists are not kept: contacts are visited in
// the order of ids, so a list collected anew gives the same bits.
#include <algorithm>
#include <stdexcept>

#include "worker/dem/leaver_columns.h"
#include "worker/dem/plain_engine.h"

namespace granary::dem {
namespace {

using core::Vec3;

void push(std::vector<double>& values, const Vec3& v) {
  values.insert(values.end(), {v.x, v.y, v.z});
}

Vec3 vector_at(const std::vector<double>& values, std::size_t row) {
  return {values[3 * row], values[3 * row + 1], values[3 * row + 2]};
}

}  // namespace

core::State PlainEngine::snapshot() const {
  std::vector<double> position, velocity, spin, carried_velocity, spring, contact_velocity;
  std::vector<double> contact_normal;  // of touches of the mesh, else 0
  std::vector<std::int64_t> id, pair;
  std::vector<std::uint8_t> grain_class, carried, fresh;
  for (const Body& body : bodies_) {
    push(position, body.position);
    push(velocity, body.velocity_half);
    push(spin, body.spin_half);
    push(carried_velocity, body.carried_velocity);
    id.push_back(body.id);
    grain_class.push_back(body.grain_class);
    carried.push_back(body.carried);
    fresh.push_back(body.fresh);
  }
  for (const Candidate& candidate : candidates_) {
    if (!candidate.touching) continue;
    pair.insert(pair.end(), {candidate.first_id, candidate.second_id});
    push(spring, candidate.spring);
    push(contact_velocity, candidate.velocity);
    push(contact_normal, candidate.touch.normal);
  }
  core::State state;
  put_leavers(state, leavers_);
  state.put("dem.position_m", "m", position, 3);
  state.put("dem.velocity_half_m_per_s", "m/s", velocity, 3);
  state.put("dem.spin_half_rad_per_s", "rad/s", spin, 3);
  state.put("dem.carried_velocity_m_per_s", "m/s", carried_velocity, 3);
  state.put("dem.id", "1", id);
  state.put("dem.class", "1", grain_class);
  state.put("dem.carried", "1", carried);
  state.put("dem.fresh", "1", fresh);
  state.put("dem.touching_ids", "1", pair, 2);
  state.put("dem.spring_m", "m", spring, 3);
  state.put("dem.contact_velocity_m_per_s", "m/s", contact_velocity, 3);
  if (!mesh_.empty()) state.put("dem.contact_normal", "1", contact_normal, 3);
  state.put_scalar("dem.step", "1", step_);
  state.put_scalar("dem.next_id", "1", next_id_);
  state.put_scalar("dem.particle_steps", "1", particle_steps_);
  state.put_scalar("dem.contact_evaluations", "1", contact_evaluations_);
  state.put_scalar("dem.largest_overlap_ratio", "1", largest_overlap_ratio_);
  state.put("dem.gravity_m_per_s2", "m/s2",
            std::vector<double>{setup_.motion.gravity.x, setup_.motion.gravity.y,
                                setup_.motion.gravity.z});
  std::vector<double> ledger(ledger_.channels_j.begin(), ledger_.channels_j.end());
  ledger.insert(ledger.end(), {ledger_.kinetic_j, ledger_.potential_j, ledger_.elastic_j,
                               ledger_.stored_at_start_j, ledger_.throughput_j});
  state.put("dem.ledger_j", "J", ledger);
  return state;
}

void PlainEngine::restore(const core::State& state) {
  const auto id = state.get<std::int64_t>("dem.id");
  const auto position = state.get<double>("dem.position_m");
  const auto velocity = state.get<double>("dem.velocity_half_m_per_s");
  const auto spin = state.get<double>("dem.spin_half_rad_per_s");
  const auto carried_velocity = state.get<double>("dem.carried_velocity_m_per_s");
  const auto grain_class = state.get<std::uint8_t>("dem.class");
  const auto carried = state.get<std::uint8_t>("dem.carried");
  const auto fresh = state.get<std::uint8_t>("dem.fresh");
  const std::size_t count = id.size();
  if (position.size() != 3 * count || velocity.size() != 3 * count || spin.size() != 3 * count ||
      carried_velocity.size() != 3 * count || grain_class.size() != count ||
      carried.size() != count || fresh.size() != count) {
    throw std::runtime_error("state: grain columns differ in length");
  }
  bodies_.assign(count, {});
  for (std::size_t k = 0; k < count; ++k) {
    Body& body = bodies_[k];
    body.id = id[k];
    body.position = vector_at(position, k);
    body.velocity_half = vector_at(velocity, k);
    body.spin_half = vector_at(spin, k);
    body.carried_velocity = vector_at(carried_velocity, k);
    body.grain_class = grain_class[k];
    body.carried = carried[k] != 0;
    body.fresh = fresh[k] != 0;
    if (body.grain_class >= setup_.classes.size()) {
      throw std::runtime_error("state: grain of a class that the scene does not have");
    }
  }
  const auto pair = state.get<std::int64_t>("dem.touching_ids");
  const auto spring = state.get<double>("dem.spring_m");
  const auto contact_velocity = state.get<double>("dem.contact_velocity_m_per_s");
  std::vector<double> normal(contact_velocity.size(), 0);
  if (!mesh_.empty()) normal = state.get<double>("dem.contact_normal");
  if (spring.size() != contact_velocity.size() || normal.size() != spring.size() ||
      2 * spring.size() != 3 * pair.size()) {
    throw std::runtime_error("state: contact columns differ in length");
  }
  candidates_.clear();
  for (std::size_t k = 0; 2 * k < pair.size(); ++k) {
    candidates_.push_back({.first_id = pair[2 * k],
                           .second_id = pair[2 * k + 1],
                           .spring = vector_at(spring, k),
                           .velocity = vector_at(contact_velocity, k),
                           .touch = {vector_at(normal, k), 0},
                           .touching = true});
  }
  contacts_.clear();
  list_is_void_ = true;
  leavers_ = get_leavers(state);
  restore_scalars(state);
}

void PlainEngine::restore_scalars(const core::State& state) {
  step_ = state.get_scalar<std::uint64_t>("dem.step");
  next_id_ = state.get_scalar<std::int64_t>("dem.next_id");
  particle_steps_ = state.get_scalar<std::uint64_t>("dem.particle_steps");
  contact_evaluations_ = state.get_scalar<std::uint64_t>("dem.contact_evaluations");
  largest_overlap_ratio_ = state.get_scalar<double>("dem.largest_overlap_ratio");
  setup_.motion.gravity = vector_at(state.get<double>("dem.gravity_m_per_s2"), 0);
  terms_ = BodyTerms(setup_.motion, setup_.time_step);
  map_ = FrameMap(setup_.motion, time());
  const auto ledger = state.get<double>("dem.ledger_j");
  if (ledger.size() != core::kEnergyChannelCount + 5) {
    throw std::runtime_error("state: ledger of another version");
  }
  std::copy_n(ledger.begin(), core::kEnergyChannelCount, ledger_.channels_j.begin());
  const auto rest = ledger.begin() + core::kEnergyChannelCount;
  ledger_.kinetic_j = rest[0];
  ledger_.potential_j = rest[1];
  ledger_.elastic_j = rest[2];
  ledger_.stored_at_start_j = rest[3];
  ledger_.throughput_j = rest[4];
  trouble_.reset();
}

}  // namespace granary::dem
