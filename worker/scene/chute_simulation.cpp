#include "worker/scene/chute_simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/core/books.h"
#include "worker/scene/chute_filling.h"

namespace granary::scene {
namespace {

// A layer enters this far upstream of x = 0, in lattice constants: more than a contact's reach.
constexpr double kEntryDepth = 2;
// A snapshot costs about as much as twenty steps.
constexpr std::uint64_t kStepsBetweenMarks = 4096;

std::vector<double> flat(const std::vector<core::Vec3>& vectors) {
  std::vector<double> values;
  values.reserve(3 * vectors.size());
  for (const core::Vec3& v : vectors) values.insert(values.end(), {v.x, v.y, v.z});
  return values;
}

}  // namespace

ChuteSimulation::ChuteSimulation(ChutePlan plan, const core::State* stored_filling)
    : plan_(std::move(plan)),
      engine_(dem::make_engine(plan_.engine)),
      observer_(plan_.geometry, plan_.sample_start, plan_.engine.classes.size() > 1) {
  if (plan_.feed) feed_.emplace(*plan_.feed);
  if (plan_.hopper) hopper_.emplace(plan_.sample_start);
  engine_->insert(plan_.beads);
  if (plan_.initial_count == 0) return;
  filling_duration_ = filling_duration(plan_);
  if (stored_filling != nullptr) {
    filling_ = *stored_filling;
    begin_flow();
  } else {
    filling_engine_ = make_filling(plan_);
  }
}

// ------------------------------------------------------------------------------------------- time

std::uint64_t ChuteSimulation::step_at(double time) const {
  const double steps = time / plan_.engine.time_step;
  return static_cast<std::uint64_t>(std::max(0.0, std::ceil(steps - 1e-9)));
}

double ChuteSimulation::now() const {
  return is_filling() ? filling_engine_->time() - filling_duration_ : engine_->time();
}

core::AdvanceOutcome ChuteSimulation::advance(double until_time_s, std::uint64_t max_steps) {
  std::uint64_t left = max_steps;
  if (is_filling()) {
    const std::uint64_t before = filling_engine_->step();
    advance_filling(until_time_s, left);
    left -= std::min(left, (is_filling() ? filling_engine_->step() : filling_steps_) - before);
  }
  const std::uint64_t last_step = step_at(plan_.duration);
  while (!is_filling() && !engine().trouble()) {
    handle_events();
    if (engine_->step() >= last_step) return {core::AdvanceStatus::finished, std::nullopt};
    if (engine_->time() >= until_time_s || left == 0) break;
    const double until = std::min(until_time_s, plan_.duration);
    const std::uint64_t target = std::min({next_event(), step_at(until), engine_->step() + left});
    const std::uint64_t before = engine_->step();
    engine_->advance(std::max<std::uint64_t>(target, before + 1) - before);
    left -= engine_->step() - before;
  }
  if (engine().trouble()) return {core::AdvanceStatus::rejected, engine().trouble()};
  return {core::AdvanceStatus::advanced, std::nullopt};
}

void ChuteSimulation::advance_filling(double until_time, std::uint64_t max_steps) {
  const double until = std::min(until_time, 0.0) + filling_duration_;
  const std::uint64_t target = std::max(step_at(until), filling_engine_->step());
  filling_engine_->advance(std::min(target - filling_engine_->step(), max_steps));
  if (filling_engine_->trouble() || filling_engine_->step() < step_at(filling_duration_)) return;
  filling_ = filling_state(*filling_engine_);
  filling_steps_ = filling_engine_->step();
  filling_particle_steps_ = filling_engine_->particle_steps();
  filling_engine_.reset();
  begin_flow();
}

void ChuteSimulation::begin_flow() {
  engine_->insert(grains_of_filling(*filling_, plan_));
}

// ----------------------------------------------------------------------------------------- events

void ChuteSimulation::handle_events() {
  if (feed_) {
    enter_layers();
    free_layers();
  }
  if (engine_->step() >= step_at(static_cast<double>(frames_sampled_) * plan_.sample_interval)) {
    sample();
  }
}

double ChuteSimulation::entry_time(std::int64_t layer) const {
  return feed_->arrival_time(layer) - kEntryDepth * feed_->lattice_constant() / feed_->speed();
}

void ChuteSimulation::enter_layers() {
  while (engine_->step() >= step_at(entry_time(layers_entered_))) {
    const std::int64_t first = engine_->insert(feed_->layer(layers_entered_, engine_->time()));
    if (layers_entered_ == 0) next_to_free_ = first;
    ++layers_entered_;
  }
}

void ChuteSimulation::free_layers() {
  while (engine_->step() >= step_at(feed_->arrival_time(layers_freed_))) {
    const auto size = static_cast<std::int64_t>(feed_->layer_size(layers_freed_));
    engine_->release(next_to_free_, next_to_free_ + size);
    next_to_free_ += size;
    ++layers_freed_;
  }
}

void ChuteSimulation::sample() {
  const std::vector<dem::Leaver> leavers = engine_->take_leavers();
  const dem::GrainTable grains = engine_->grains();
  observer_.sample(engine_->time(), grains, leavers);
  if (hopper_) hopper_->sample(engine_->time(), grains);
  ++frames_sampled_;
}

std::uint64_t ChuteSimulation::next_event() const {
  std::uint64_t next = step_at(static_cast<double>(frames_sampled_) * plan_.sample_interval);
  if (feed_) {
    next = std::min(
        {next, step_at(entry_time(layers_entered_)), step_at(feed_->arrival_time(layers_freed_))});
  }
  return next;
}

// ------------------------------------------------------------------------------------- what shows

core::SimulationProgress ChuteSimulation::progress() const {
  core::SimulationProgress progress;
  const double whole = filling_duration_ + plan_.duration;
  progress.fraction = whole > 0 ? std::clamp((now() + filling_duration_) / whole, 0.0, 1.0) : 1;
  progress.phase = is_filling() ? "filling" : "flow";
  progress.time_s = now();
  progress.end_time_s = plan_.duration;
  progress.steps = filling_steps_ + engine().step() - steps_not_made_;
  progress.particle_steps = filling_particle_steps_ + engine().particle_steps();
  progress.particles = engine().grain_count();
  progress.contacts = engine().contact_count();
  progress.current_values = observer_.current_values();
  return progress;
}

core::Observation ChuteSimulation::observe() const {
  core::Observation observation = observer_.observe();
  if (hopper_) hopper_->add_to(observation);
  const dem::EffectCounts counts = engine_->effect_counts();
  observation.effect_evaluations = {{"gas", 0},
                                    {"rotating_frame", counts.rotating_frame},
                                    {"rolling_friction", counts.rolling_friction},
                                    {"particle_rotation", counts.spin},
                                    {"tangential_history", counts.tangential_history},
                                    {"cohesion", counts.cohesion}};
  return observation;
}

std::vector<core::ColumnView> ChuteSimulation::frame() const {
  const dem::GrainTable grains = engine().grains();
  shown_.clear();
  shown_.push_back(core::make_column<double>("position_m", "m", flat(grains.position), 3));
  shown_.push_back(core::make_column<double>("velocity_m_per_s", "m/s", flat(grains.velocity), 3));
  shown_.push_back(core::make_column<double>("spin_rad_per_s", "rad/s", flat(grains.spin), 3));
  shown_.push_back(core::make_column<double>("radius_m", "m", grains.radius));
  shown_.push_back(core::make_column<std::int64_t>("id", "1", grains.id));
  shown_.push_back(core::make_column<std::uint8_t>("class", "1", grains.grain_class));
  std::vector<core::ColumnView> views;
  for (const core::Column& column : shown_) views.push_back(core::view_of(column));
  return views;
}

std::vector<core::ColumnView> ChuteSimulation::physical_state() const {
  shown_ = engine().snapshot().columns;
  // Part of the lists, and infinite where a block has no wall to come near to.
  std::erase_if(shown_, [](const core::Column& column) { return column.name == "dem.wall_rooms"; });
  std::vector<core::ColumnView> views;
  for (const core::Column& column : shown_) views.push_back(core::view_of(column));
  return views;
}

// --------------------------------------------------------------------------------------- recovery

std::uint64_t ChuteSimulation::steps_between_marks() const {
  return core::kBooks ? kStepsBetweenMarks : core::kNever;
}

bool ChuteSimulation::knows(core::Remedy remedy) const {
  return remedy == core::Remedy::halve_time_step;
}

core::SettingChange ChuteSimulation::apply(core::Remedy) {
  const double before = plan_.engine.time_step;
  plan_.engine.time_step = 0.5 * before;
  steps_not_made_ += engine().step();
  engine_->halve_time_step();
  if (filling_engine_) filling_engine_->halve_time_step();
  return {"chute.time_step_s", before, plan_.engine.time_step};
}

// ------------------------------------------------------------------------------------ checkpoints

core::State ChuteSimulation::snapshot() const {
  core::State state = engine().snapshot();
  observer_.save(state);
  if (hopper_) hopper_->save(state);
  state.put_scalar<std::uint8_t>("chute.filling", "1", is_filling() ? 1 : 0);
  state.put_scalar("chute.filling_steps", "1", filling_steps_);
  state.put_scalar("chute.filling_particle_steps", "1", filling_particle_steps_);
  state.put_scalar("chute.steps_not_made", "1", steps_not_made_);
  state.put_scalar("chute.layers_entered", "1", layers_entered_);
  state.put_scalar("chute.layers_freed", "1", layers_freed_);
  state.put_scalar("chute.next_to_free", "1", next_to_free_);
  state.put_scalar("chute.frames_sampled", "1", frames_sampled_);
  if (filling_) {
    for (const core::Column& column : filling_->columns) state.put(column);
  }
  return state;
}

void ChuteSimulation::restore(const core::State& state) {
  filling_.reset();
  if (state.get_scalar<std::uint8_t>("chute.filling") != 0) {
    engine_ = dem::make_engine(plan_.engine);  // what was filled into it has not happened yet
    engine_->insert(plan_.beads);
    filling_engine_ = make_filling(plan_);
    filling_engine_->restore(state);
  } else {
    filling_engine_.reset();
    engine_->restore(state);
  }
  observer_.load(state);
  if (hopper_) hopper_->load(state);
  filling_steps_ = state.get_scalar<std::uint64_t>("chute.filling_steps");
  filling_particle_steps_ = state.get_scalar<std::uint64_t>("chute.filling_particle_steps");
  steps_not_made_ = state.get_scalar<std::uint64_t>("chute.steps_not_made");
  layers_entered_ = state.get_scalar<std::int64_t>("chute.layers_entered");
  layers_freed_ = state.get_scalar<std::int64_t>("chute.layers_freed");
  next_to_free_ = state.get_scalar<std::int64_t>("chute.next_to_free");
  frames_sampled_ = state.get_scalar<std::uint64_t>("chute.frames_sampled");
  if (state.find("filling.class") != nullptr) {
    core::State filling;
    filling.put(*state.find("filling.position_m"));
    filling.put(*state.find("filling.class"));
    filling_ = std::move(filling);
  }
}

}  // namespace granary::scene
