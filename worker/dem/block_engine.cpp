#include "worker/dem/block_engine.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace granary::dem {

using core::EnergyChannel;
using core::Vec3;

namespace {

// The inner list looks this share of the shortest collision ahead: collisions bend paths by less
// than the margin in that time.
constexpr double kHorizonInCollisions = 0.4;
constexpr std::uint64_t kShortestHorizon = 4, kLongestHorizon = 64;  // steps
constexpr double kSkinInDiameters = 0.5;
constexpr double kMarginInDiameters = 0.01;
// Steps that one thread takes at once along the front: k + 2 blocks should fit into its cache.
constexpr std::size_t kFrontSteps = 4;
constexpr std::uint64_t kTimedWindows = 16;  // every so many windows are timed by phase

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double smallest_radius(const EngineSetup& setup) {
  double smallest = setup.classes.front().radius;
  for (const GrainClass& c : setup.classes) smallest = std::min(smallest, c.radius);
  return smallest;
}

std::uint64_t horizon_steps(const EngineSetup& setup) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const GrainClass& c : setup.classes) {
    shortest = std::min({shortest, collision_time(setup.grain_grain, 0.5 * c.mass()),
                         collision_time(setup.grain_wall, c.mass())});
  }
  const double steps = kHorizonInCollisions * shortest / setup.time_step;
  return static_cast<std::uint64_t>(std::clamp(steps, static_cast<double>(kShortestHorizon),
                                               static_cast<double>(kLongestHorizon)));
}

bool some_rolling_arm(const EngineSetup& setup) {
  return setup.grain_grain.rolling_friction > 0 || setup.grain_wall.rolling_friction > 0;
}

const EngineSetup& checked(const EngineSetup& setup) {
  if (BlockEngine::covers(setup)) return setup;
  throw std::invalid_argument("the block engine does not cover this setup");
}

}  // namespace

bool BlockEngine::covers(const EngineSetup& setup) {
  const bool walls_turn = setup.motion.frame == FrameKind::inertial && setup.motion.rotates();
  return setup.precision == Precision::mixed && setup.damping == Damping::semi_implicit &&
         !walls_turn && effect_combination(setup.effects, some_rolling_arm(setup)).has_value();
}

BlockEngine::BlockEngine(const EngineSetup& setup, const Kernels& kernels)
    : setup_(checked(setup)),
      kernels_(kernels),
      terms_(setup.motion, setup.time_step),
      laws_(law_tables(setup)),
      wall_tables_(wall_tables(setup.walls)),
      mesh_(setup.triangles),
      mesh_laws_(mesh_laws()),
      body_(body_coefficients(setup)),
      combination_(*effect_combination(setup.effects, some_rolling_arm(setup))),
      integrate_((setup.motion.rotates() ? kernels.integrate_rotating
                                         : kernels.integrate)[setup.effects.spin ? 1 : 0]),
      horizon_(horizon_steps(setup)),
      skin_(kSkinInDiameters * 2 * smallest_radius(setup)),
      margin_(kMarginInDiameters * 2 * smallest_radius(setup)),
      crew_(std::max(1U, setup.threads)),
      contacts_done_(crew_.size()),
      motion_done_(crew_.size()) {}

// ------------------------------------------------------------------------------ grains in and out

std::int64_t BlockEngine::insert(std::span<const Grain> grains) {
  const std::int64_t first = next_id_;
  for (const Grain& grain : grains) {
    const GrainClass& grain_class = setup_.classes[grain.grain_class];
    Vec3 velocity = grain.velocity;
    Vec3 spin = grain.spin;
    if (!grain.carried) velocity = terms_.half_step_back(velocity, grain.position);
    spin = setup_.effects.spin ? terms_.spin_half_step_back(spin) : Vec3{};
    GrainMotion motion{{grain.position.x, grain.position.y, grain.position.z},
                       1 / grain_class.mass(),
                       {velocity.x, velocity.y, velocity.z},
                       grain.carried ? 0 : setup_.time_step};
    const Vec3 speed = spin * grain_class.radius;
    motion_.push_back(motion);
    surface_.push_back({{speed.x, speed.y, speed.z}, grain_class.radius});
    id_.push_back(next_id_++);
    class_.push_back(grain.grain_class);
    fresh_.push_back(1);
    if (!grain.carried) book_transfer(EnergyChannel::inlet, motion_.size() - 1, 1);
  }
  order_is_void_ = true;
  return first;
}

void BlockEngine::release(std::int64_t first, std::int64_t end) {
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    if (!is_carried(k) || id_[k] < first || id_[k] >= end) continue;
    GrainMotion& m = motion_[k];
    const Vec3 velocity = terms_.half_step_back({m.velocity[0], m.velocity[1], m.velocity[2]},
                                                {m.position[0], m.position[1], m.position[2]});
    m.velocity[0] = velocity.x;
    m.velocity[1] = velocity.y;
    m.velocity[2] = velocity.z;
    m.free_step = setup_.time_step;
    fresh_[k] = 1;
    book_transfer(EnergyChannel::inlet, k, 1);
    order_is_void_ = true;
  }
}

void BlockEngine::set_gravity(const Vec3& gravity) {
  flush_ledger();
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    if (!is_carried(k)) book_transfer(EnergyChannel::outlet, k, -1);
  }
  setup_.motion.gravity = gravity;
  terms_ = BodyTerms(setup_.motion, setup_.time_step);
  body_ = body_coefficients(setup_);
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    if (!is_carried(k)) book_transfer(EnergyChannel::inlet, k, 1);
  }
  begin_ledger_span();
}

// Within the step that crosses the outlet the grain moves in a straight line.
void BlockEngine::log_leavers(Block& block, std::uint64_t step) {
  const double dt = setup_.time_step;
  for (std::uint32_t k = block.range.first; k < block.range.first + block.range.count; ++k) {
    const GrainMotion& m = motion_[k];
    const Vec3 now{m.position[0], m.position[1], m.position[2]};
    const Vec3 velocity{m.velocity[0], m.velocity[1], m.velocity[2]};
    if (now.x <= setup_.outlet_x || now.x - velocity.x * dt > setup_.outlet_x) continue;
    const double back = (now.x - setup_.outlet_x) / velocity.x;
    block.leavers.push_back({static_cast<double>(step + 1) * dt - back, id_[k],
                             now - velocity * back, velocity, 2 * surface_[k].radius, mass(k)});
  }
}

void BlockEngine::gather_leavers() {
  for (std::size_t b = 0; b < block_count_; ++b) {
    leavers_.insert(leavers_.end(), blocks_[b].leavers.begin(), blocks_[b].leavers.end());
    blocks_[b].leavers.clear();
  }
}

std::vector<Leaver> BlockEngine::take_leavers() {
  gather_leavers();
  std::vector<Leaver> taken = std::exchange(leavers_, {});
  std::sort(taken.begin(), taken.end(), [](const Leaver& l, const Leaver& r) {
    return l.time != r.time ? l.time < r.time : l.id < r.id;
  });
  return taken;
}

GrainTable BlockEngine::grains() const {
  GrainTable table;
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    const GrainMotion& m = motion_[k];
    const Vec3 position{m.position[0], m.position[1], m.position[2]};
    const Vec3 half{m.velocity[0], m.velocity[1], m.velocity[2]};
    const Vec3 speed{surface_[k].speed[0], surface_[k].speed[1], surface_[k].speed[2]};
    const Vec3 spin = speed * (1 / surface_[k].radius);
    table.id.push_back(id_[k]);
    table.position.push_back(position);
    table.velocity.push_back(is_carried(k) ? half : terms_.half_step_on(half, position));
    table.spin.push_back(setup_.effects.spin ? terms_.spin_half_step_on(spin) : spin);
    table.radius.push_back(surface_[k].radius);
    table.mass.push_back(mass(k));
    table.grain_class.push_back(class_[k]);
    table.carried.push_back(is_carried(k) ? 1 : 0);
  }
  return table;
}

std::size_t BlockEngine::contact_count() const {
  std::size_t count = 0;
  for (std::size_t b = 0; b < block_count_; ++b) {
    for (const SlotList* list : {&blocks_[b].pair_slots, &blocks_[b].wall_slots}) {
      for (std::size_t slot = 0; slot < list->size(); ++slot) count += list->touching(slot) ? 1 : 0;
    }
    count += blocks_[b].mesh_contacts.size();
  }
  return count;
}

EffectCounts BlockEngine::effect_counts() const {
  std::uint64_t contacts = contact_evaluations_;
  for (std::size_t b = 0; b < block_count_; ++b) contacts += blocks_[b].sums.contacts;
  const ContactEffects& effects = kEffectCombinations[combination_].effects;
  return {.tangential_history = effects.tangential_history ? contacts : 0,
          .rolling_friction = effects.rolling_friction ? contacts : 0,
          .spin = effects.spin ? particle_steps_ : 0,
          .cohesion = effects.cohesion ? contacts : 0,
          .rotating_frame = setup_.motion.rotates() ? particle_steps_ : 0};
}

std::size_t BlockEngine::inner_slots() const {
  std::size_t count = 0;
  for (std::size_t b = 0; b < block_count_; ++b) {
    count += blocks_[b].pair_slots.size() + blocks_[b].wall_slots.size();
  }
  return count;
}

std::size_t BlockEngine::outer_pairs() const {
  std::size_t count = 0;
  for (std::size_t b = 0; b < block_count_; ++b) count += blocks_[b].pairs.count;
  return count;
}

// --------------------------------------------------------------------------------------- the step

void BlockEngine::advance(std::uint64_t steps) {
  const std::uint64_t target = step_ + steps;
  while (step_ < target && !trouble_) {
    if (order_is_void_ || step_ >= next_refresh_) {
      refresh_lists();
      continue;
    }
    run_steps(std::min(target, next_refresh_) - step_);
  }
}

void BlockEngine::run_steps(std::uint64_t count) {
  const double start = seconds_now();
  if (crew_.size() == 1 || block_count_ < 2) {
    run_front(count, windows_ % kTimedWindows == 0);
  } else {
    for (Milestone& milestone : contacts_done_) milestone.reset();
    for (Milestone& milestone : motion_done_) milestone.reset();
    crew_.run([&](unsigned worker) { run_region(worker, count); });
  }
  step_ += count;
  particle_steps_ += count * free_count_;
  ++windows_;
  window_seconds_ += seconds_now() - start;
}

// One thread: block b takes step k right after block b + 1 took step k - 1.
void BlockEngine::run_front(std::uint64_t count, bool timed) {
  const auto blocks = static_cast<std::int64_t>(block_count_);
  for (std::uint64_t begun = 0; begun < count; begun += kFrontSteps) {
    const auto steps =
        static_cast<std::int64_t>(std::min<std::uint64_t>(kFrontSteps, count - begun));
    for (std::int64_t front = 0; front < blocks + steps - 1; ++front) {
      for (std::int64_t k = std::max<std::int64_t>(0, front - blocks + 1);
           k < std::min(steps, front + 1); ++k) {
        const auto b = static_cast<std::size_t>(front - k);
        const double before = timed ? seconds_now() : 0;
        meet(blocks_[b], desks_[0].own);
        const double between = timed ? seconds_now() : 0;
        move(b, step_ + begun + static_cast<std::uint64_t>(k), desks_[0].own);
        if (!timed) continue;
        timed_contacts_ += between - before;
        timed_motion_ += seconds_now() - between;
      }
    }
  }
}

// Each worker owns a run of blocks and begins a step with the contacts its neighbour downstream
// waits for, so that nobody waits for a whole step.
void BlockEngine::run_region(unsigned worker, std::uint64_t count) {
  const std::size_t begin = region_start_[worker], end = region_start_[worker + 1];
  if (begin == end) return;
  const std::size_t last = end - 1;
  Desk& desk = desks_[worker];
  for (std::uint64_t k = 0; k < count; ++k) {
    if (end < block_count_) motion_done_[worker + 1].wait_for(k);
    meet(blocks_[last], desk.last);
    contacts_done_[worker].raise();
    for (std::size_t b = begin; b < end; ++b) {
      if (b != last) meet(blocks_[b], desk.own);
      if (b == begin && worker > 0) contacts_done_[worker - 1].wait_for(k + 1);
      move(b, step_ + k, b == last ? desk.last : desk.own);
      if (b == begin) motion_done_[worker].raise();
    }
  }
}

BlockArrays BlockEngine::arrays(Block& block, LineVector<GrainLoad>& desk) {
  return {&motion_[block.range.first], &surface_[block.range.first], desk.data(),
          block.range.count};
}

// Every desk holds the largest block, with all that it may push.
void BlockEngine::clear_desks() {
  std::size_t largest = 0;
  for (std::size_t b = 0; b < block_count_; ++b) {
    const BlockRange& range = blocks_[b].range;
    largest = std::max<std::size_t>(largest, range.count + range.outflow);
    blocks_[b].outgoing.resize(range.outflow);
  }
  desks_.resize(crew_.size());
  for (Desk& desk : desks_) {
    desk.own.assign(largest, {});
    desk.last.assign(largest, {});
  }
}

void BlockEngine::meet(Block& block, LineVector<GrainLoad>& desk) {
  ContactTask task;
  task.block = arrays(block, desk);
  task.time_step = static_cast<float>(setup_.time_step);
  task.slots = block.pair_slots.arrays();
  task.laws = &laws_.pairs;
  if (task.slots.count > 0) kernels_.pairs[combination_](task, block.sums);
  task.slots = block.wall_slots.arrays();
  task.laws = &laws_.walls;
  task.walls = &wall_tables_;
  if (task.slots.count > 0) kernels_.walls[combination_](task, block.sums);
  if (!block.mesh_rows.empty()) meet_mesh(block, desk);
  for (std::uint32_t k = 0; k < block.range.outflow; ++k) {
    block.outgoing[k] = std::exchange(desk[block.range.count + k], {});
  }
}

void BlockEngine::move(std::size_t index, std::uint64_t step, LineVector<GrainLoad>& desk) {
  Block& block = blocks_[index];
  if (block.has_carried) book_carried(index, desk);
  IntegrateTask task;
  task.block = arrays(block, desk);
  task.body = &body_;
  task.inflow_count = block.inflow;
  if (block.inflow > 0) task.inflow = blocks_[index - 1].outgoing.data();
  integrate_(task);
  if (block.nears_outlet) log_leavers(block, step);
}

// A carried grain moves on whatever pushes it, so it does work on those who push.
void BlockEngine::book_carried(std::size_t index, const LineVector<GrainLoad>& desk) {
  Block& block = blocks_[index];
  const GrainLoad* inflow = block.inflow > 0 ? blocks_[index - 1].outgoing.data() : nullptr;
  for (std::uint32_t k = 0; k < block.range.count; ++k) {
    const GrainMotion& m = motion_[block.range.first + k];
    if (m.free_step != 0) continue;
    const GrainSurface& s = surface_[block.range.first + k];
    const auto power = [&](const GrainLoad& load) {
      double sum = 0;
      for (int i = 0; i < 3; ++i)
        sum += load.force[i] * m.velocity[i] + load.turning[i] * s.speed[i];
      return sum;
    };
    block.inlet_work -=
        setup_.time_step * (power(desk[k]) + (k < block.inflow ? power(inflow[k]) : 0));
  }
}

// Regions of equal cost: a contact costs about as much as two motions.
void BlockEngine::divide_work() {
  const auto cost = [](const Block& block) {
    return static_cast<double>(block.range.count) +
           2.0 * static_cast<double>(block.pair_slots.size());
  };
  double total = 0;
  for (std::size_t b = 0; b < block_count_; ++b) total += cost(blocks_[b]);
  region_start_.assign(crew_.size() + 1, block_count_);
  region_start_[0] = 0;
  double done = 0;
  std::size_t region = 1;
  for (std::size_t b = 0; b < block_count_ && region < crew_.size(); ++b) {
    done += cost(blocks_[b]);
    if (done * crew_.size() >= total * static_cast<double>(region)) region_start_[region++] = b + 1;
  }
}

void BlockEngine::count_free() {
  free_count_ = 0;
  for (std::size_t k = 0; k < motion_.size(); ++k) free_count_ += is_carried(k) ? 0 : 1;
}

void BlockEngine::watch() {
  bool sound = true;
  double path = 0;
  for (std::size_t b = 0; b < block_count_; ++b) {
    sound = sound && blocks_[b].is_sound;
    path = std::max(path, blocks_[b].path_ratio);
    const double ratio = blocks_[b].sums.largest_overlap_ratio;
    largest_overlap_ratio_ = std::max(largest_overlap_ratio_, ratio);
  }
  if (!sound) {
    trouble_ = not_a_number(time(), broken_ids());
  } else if (largest_overlap_ratio_ > kLargestSoundOverlap) {
    trouble_ = overlap_too_deep(time(), largest_overlap_ratio_, deepest_ids());
  } else if (path > kLongestSoundPath && can_pass_through(motion_.size(), !mesh_.empty())) {
    trouble_ = path_too_long(time(), path, fast_ids());
  }
}

double BlockEngine::path_ratio(std::size_t grain) const {
  const double* v = motion_[grain].velocity;
  return setup_.time_step * norm(Vec3{v[0], v[1], v[2]}) / surface_[grain].radius;
}

std::vector<std::int64_t> BlockEngine::fast_ids() const {
  std::vector<std::int64_t> ids;
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    if (path_ratio(k) > kLongestSoundPath) ids.push_back(id_[k]);
  }
  return ids;
}

std::vector<std::int64_t> BlockEngine::broken_ids() const {
  std::vector<std::int64_t> ids;
  for (std::size_t k = 0; k < motion_.size(); ++k) {
    const GrainMotion& m = motion_[k];
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += m.position[i] + m.velocity[i];
    if (!std::isfinite(sum)) ids.push_back(id_[k]);
  }
  return ids;
}

// A quarter of a step's kick is left out for once: velocities were half a step before the
// positions, and count as a quarter of it from now on.
void BlockEngine::halve_time_step() {
  flush_ledger();
  setup_.time_step *= 0.5;
  step_ *= 2;
  ordered_at_ = next_refresh_ = step_;
  terms_ = BodyTerms(setup_.motion, setup_.time_step);
  laws_ = law_tables(setup_);
  mesh_laws_ = mesh_laws();
  body_ = body_coefficients(setup_);
  horizon_ = horizon_steps(setup_);
  for (GrainMotion& m : motion_)
    if (m.free_step != 0) m.free_step = setup_.time_step;
  order_is_void_ = true;
  largest_overlap_ratio_ = 0;
  trouble_.reset();
  begin_ledger_span();
}

std::vector<core::PhaseSeconds> BlockEngine::profile() const {
  const double timed = timed_contacts_ + timed_motion_;
  const double contacts = timed > 0 ? window_seconds_ * timed_contacts_ / timed : 0;
  return {{"neighbour lists", list_seconds_},
          {"contacts", contacts},
          {"motion", window_seconds_ - contacts}};
}

}  // namespace granary::dem
