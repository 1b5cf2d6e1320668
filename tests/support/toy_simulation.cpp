#include "tests/support/toy_simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "worker/core/random.h"

namespace granary::testing {
namespace {

constexpr double kStiffness = 100;
constexpr double kFillingDamping = 2;
constexpr std::uint64_t kShakeEvery = 50;
constexpr std::uint64_t kSampleEvery = 10;

void spin(std::uint64_t microseconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(microseconds);
  while (std::chrono::steady_clock::now() < end) {
  }
}

}  // namespace

ToyOptions toy_options(const v1::Scene& scene) {
  ToyOptions options;
  options.count = scene.discharge().particles().count();
  options.time_step_s = scene.discharge().time_step_s();
  options.duration_s = scene.discharge().duration_s();
  options.seed = scene.seed();
  std::istringstream words(scene.name());
  for (std::string word; words >> word;) {
    const std::size_t at = word.find('=');
    const std::uint64_t number = at == std::string::npos ? 1 : std::stoull(word.substr(at + 1));
    const std::string key = word.substr(0, at);
    if (key == "spin_us") options.spin_us = number;
    if (key == "nan_at_step") options.nan_at_step = number;
    if (key == "reject_at_step") options.reject_at_step = number;
    if (key == "crash_at_step") options.crash_at_step = number;
    if (key == "nan_value") options.nan_value = true;
    if (key == "stuck") options.stuck = true;
  }
  return options;
}

v1::Scene toy_scene(const std::string& knobs) {
  v1::Scene scene;
  scene.set_name("toy " + knobs);
  scene.set_seed(7);
  v1::Discharge& discharge = *scene.mutable_discharge();
  discharge.mutable_particles()->set_count(8);
  discharge.mutable_particles()->set_diameter_min_m(0.005);
  discharge.mutable_particles()->set_density_kg_per_m3(1000);
  discharge.set_friction_pp_deg(20);
  discharge.set_friction_pw_deg(20);
  discharge.set_rotation_rad_per_s(3);
  discharge.set_time_step_s(1e-3);
  discharge.set_duration_s(1);
  return scene;
}

ToySimulation::ToySimulation(const ToyOptions& options, const core::State* filling)
    : options_(options),
      filling_steps_(
          static_cast<std::uint64_t>(std::lround(options.filling_s / options.time_step_s))),
      position_m_(2 * options.count),
      velocity_m_per_s_(2 * options.count),
      radius_m_(options.count, 0.005),
      id_(options.count) {
  for (std::size_t i = 0; i < options.count; ++i) {
    id_[i] = static_cast<std::int64_t>(i);
    position_m_[2 * i] = 0.1 * core::random_uniform(options.seed, 0, i);
  }
  ledger_.kinetic_j = energy_j();
  ledger_.stored_at_start_j = ledger_.kinetic_j;
  if (filling != nullptr) restore(*filling);
}

double ToySimulation::time_s() const {
  return (static_cast<double>(steps_) - static_cast<double>(filling_steps_)) * options_.time_step_s;
}

double ToySimulation::spring_force(std::size_t i) const {
  const double left = i == 0 ? 0 : position_m_[2 * (i - 1)];
  const double right = i + 1 == options_.count ? 0 : position_m_[2 * (i + 1)];
  return kStiffness * (left + right - 2 * position_m_[2 * i]);
}

double ToySimulation::energy_j() const {
  double energy = 0;
  double previous = 0;
  for (std::size_t i = 0; i < options_.count; ++i) {
    const double stretch = position_m_[2 * i] - previous;
    energy += 0.5 * kStiffness * stretch * stretch +
              0.5 * velocity_m_per_s_[2 * i] * velocity_m_per_s_[2 * i];
    previous = position_m_[2 * i];
  }
  return energy + 0.5 * kStiffness * previous * previous;
}

void ToySimulation::shake() {
  for (std::size_t i = 0; i < options_.count; ++i)
    velocity_m_per_s_[2 * i] += 0.2 * (core::random_uniform(options_.seed, 1 + i, steps_) - 0.5);
}

void ToySimulation::step() {
  if (steps_ == options_.crash_at_step) std::abort();
  if (options_.spin_us > 0) spin(options_.spin_us);
  const double dt = options_.time_step_s;
  const bool filling = steps_ < filling_steps_;
  if (!filling && steps_ % kShakeEvery == 0) shake();
  for (std::size_t i = 0; i < options_.count; ++i) {
    const double damping = filling ? kFillingDamping * velocity_m_per_s_[2 * i] : 0;
    velocity_m_per_s_[2 * i] += dt * (spring_force(i) - damping);
  }
  for (std::size_t i = 0; i < options_.count; ++i)
    position_m_[2 * i] += dt * velocity_m_per_s_[2 * i];
  if (steps_ == options_.nan_at_step) velocity_m_per_s_[0] = std::nan("");
  ++steps_;
  // Whatever was not in the energy before came from the shaker or went into the damper.
  const double before = ledger_.kinetic_j;
  ledger_.kinetic_j = energy_j();
  ledger_[filling ? core::EnergyChannel::normal_damping : core::EnergyChannel::wall_work] -=
      ledger_.kinetic_j - before;
  ledger_.throughput_j += std::abs(ledger_.kinetic_j - before);
  if (steps_ == filling_steps_) filling_ = snapshot();
  if (steps_ % kSampleEvery == 0) {
    series_time_s_.push_back(time_s());
    series_energy_j_.push_back(ledger_.kinetic_j);
  }
}

core::AdvanceOutcome ToySimulation::advance(double until_time_s, std::uint64_t max_steps) {
  if (options_.stuck) return {};
  for (std::uint64_t i = 0; i < max_steps && time_s() < until_time_s; ++i) {
    if (time_s() >= options_.duration_s - 1e-9) return {core::AdvanceStatus::finished, {}};
    if (steps_ == options_.reject_at_step)
      return {core::AdvanceStatus::rejected,
              core::Rejection{time_s(), "the toy was told to give up", {3, 5}, "do not tell it"}};
    step();
  }
  return {time_s() >= options_.duration_s - 1e-9 ? core::AdvanceStatus::finished
                                                 : core::AdvanceStatus::advanced,
          {}};
}

core::SimulationProgress ToySimulation::progress() const {
  core::SimulationProgress now;
  const double total_s = options_.duration_s + options_.filling_s;
  now.fraction = 0.999 * (time_s() + options_.filling_s) / total_s;  // as engines do: a guess
  now.phase = time_s() < 0 ? "filling" : "swinging";
  now.time_s = time_s();
  now.end_time_s = options_.duration_s;
  now.steps = steps_;
  now.particle_steps = steps_ * options_.count;
  now.particles = options_.count;
  now.contacts = options_.count + 1;
  now.current_values = {{"f1_m", position_m_[0]}};
  return now;
}

core::Observation ToySimulation::observe() const {
  core::Observation seen;
  double mean = 0;
  for (std::size_t i = 0; i < options_.count; ++i) mean += position_m_[2 * i];
  mean /= static_cast<double>(options_.count);
  seen.values.push_back({"f1_m", "m", options_.nan_value ? std::nan("") : mean, {}, ""});
  seen.values.push_back({"f2_m", "m", ledger_.kinetic_j, 0.5, "given by the toy"});
  seen.values.push_back({"f4_m", "m", {}, {}, "nothing landed"});
  core::Table energy{"energy", {}};
  energy.columns.push_back(core::make_column<double>("time_s", "s", series_time_s_));
  energy.columns.push_back(core::make_column<double>("energy_j", "J", series_energy_j_));
  seen.series.push_back(std::move(energy));
  core::Table shape{"shape", {}};
  shape.columns.push_back(core::make_column<double>("position_m", "m", position_m_, 2));
  seen.fields.push_back(std::move(shape));
  seen.warnings.push_back("only a toy");
  seen.effect_evaluations = {{"gas", 0}};
  return seen;
}

namespace {

template <typename T>
core::ColumnView view(std::string_view name, std::string_view unit, const std::vector<T>& values,
                      std::size_t width = 1) {
  return {name, unit, core::element_type_of<T>(), values.size() / width, width, values.data()};
}

}  // namespace

std::vector<core::ColumnView> ToySimulation::frame() const {
  return {view("position_m", "m", position_m_, 2), view("radius_m", "m", radius_m_),
          view("id", "1", id_)};
}

std::vector<core::ColumnView> ToySimulation::physical_state() const {
  return {view("position_m", "m", position_m_, 2),
          view("velocity_m_per_s", "m/s", velocity_m_per_s_, 2)};
}

core::State ToySimulation::snapshot() const {
  core::State state;
  state.put_scalar("steps", "1", steps_);
  state.put("position_m", "m", position_m_, 2);
  state.put("velocity_m_per_s", "m/s", velocity_m_per_s_, 2);
  state.put("series_time_s", "s", series_time_s_);
  state.put("series_energy_j", "J", series_energy_j_);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&ledger_);
  state.put("ledger", "1", std::vector<std::uint8_t>(bytes, bytes + sizeof ledger_));
  return state;
}

void ToySimulation::restore(const core::State& state) {
  if (state.get<double>("position_m").size() != position_m_.size())
    throw std::runtime_error("toy: a state of another chain");
  steps_ = state.get_scalar<std::uint64_t>("steps");
  position_m_ = state.get<double>("position_m");
  velocity_m_per_s_ = state.get<double>("velocity_m_per_s");
  series_time_s_ = state.get<double>("series_time_s");
  series_energy_j_ = state.get<double>("series_energy_j");
  const auto bytes = state.get<std::uint8_t>("ledger");
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<std::uint8_t*>(&ledger_));
}

std::optional<core::State> ToySimulation::stored_filling() const {
  return filling_;
}

std::vector<core::PhaseSeconds> ToySimulation::profile() const {
  return {{"springs", 1e-6}};
}

run::SimulationFactory toy_factory() {
  return [](const v1::Scene& scene, const core::State* filling) {
    return std::make_unique<ToySimulation>(toy_options(scene), filling);
  };
}

}  // namespace granary::testing
