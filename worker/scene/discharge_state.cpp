// Checkpoint and stored filling of a discharge as named columns. Restoring gives every bit back:
// disks, candidate lists in their coloured order with the forces in them, the path prediction of
// the neighbour lists, counters, ledger and record.
#include <algorithm>
#include <span>
#include <stdexcept>

#include "worker/scene/discharge_simulation.h"

namespace granary::scene {
namespace {

using core::make_column;
using core::State;

// Records of doubles as rows.
template <typename Record>
void put_records(State& state, const std::string& name, const std::string& unit,
                 std::span<const Record> records) {
  static_assert(sizeof(Record) % sizeof(double) == 0);
  constexpr std::size_t width = sizeof(Record) / sizeof(double);
  const auto* numbers = reinterpret_cast<const double*>(records.data());
  state.put(make_column<double>(name, unit, std::span(numbers, records.size() * width), width));
}

template <typename Record, typename Vector>
void get_records(const State& state, const std::string& name, Vector& records) {
  const std::vector<double> numbers = state.get<double>(name);
  constexpr std::size_t width = sizeof(Record) / sizeof(double);
  if (numbers.size() % width != 0)
    throw std::runtime_error("state: " + name + " has a wrong width");
  records.resize(numbers.size() / width);
  if (!numbers.empty())
    std::memcpy(static_cast<void*>(records.data()), numbers.data(), numbers.size() * sizeof(double));
}

void put_disks(const dda::Disks& disks, State& state) {
  put_records<dda::DiskPose>(state, "disk_pose", "m, m, m, rad", disks.pose);
  put_records<dda::DiskMotion>(state, "disk_motion", "m/s, m/s, m/s, 1/kg", disks.motion);
  state.put("disk_id", "1", disks.id);
  state.put("disk_stratum", "1", disks.stratum);
  state.put("disk_landed", "1", disks.landed);
}

void get_disks(const State& state, dda::Disks& disks) {
  get_records<dda::DiskPose>(state, "disk_pose", disks.pose);
  get_records<dda::DiskMotion>(state, "disk_motion", disks.motion);
  disks.id = state.get<std::uint32_t>("disk_id");
  disks.stratum = state.get<std::uint32_t>("disk_stratum");
  disks.landed = state.get<std::uint8_t>("disk_landed");
  const std::size_t count = disks.id.size();
  if (disks.pose.size() != count + 1 || disks.motion.size() != count + 1 ||
      disks.stratum.size() != count || disks.landed.size() != count)
    throw std::runtime_error("state: the disk columns differ in length");
}

void put_list(const std::string& name, const dda::CandidateList& list, State& state) {
  state.put(make_column<std::int32_t>(name + "_first", "1", std::span(list.first)));
  state.put(make_column<std::int32_t>(name + "_second", "1", std::span(list.second)));
  state.put(make_column<double>(name + "_normal_force", "N", std::span(list.normal_force)));
  state.put(make_column<double>(name + "_tangential_force", "N", std::span(list.tangential_force)));
  state.put(make_column<double>(name + "_rolling_force", "N", std::span(list.rolling_force)));
  state.put(name + "_colour_start", "1", list.colour_start);
}

template <typename T, typename Vector>
void get_values(const State& state, const std::string& name, Vector& values) {
  const std::vector<T> read = state.get<T>(name);
  values.assign(read.begin(), read.end());
}

void get_list(const State& state, const std::string& name, dda::CandidateList& list) {
  get_values<std::int32_t>(state, name + "_first", list.first);
  get_values<std::int32_t>(state, name + "_second", list.second);
  get_values<double>(state, name + "_normal_force", list.normal_force);
  get_values<double>(state, name + "_tangential_force", list.tangential_force);
  get_values<double>(state, name + "_rolling_force", list.rolling_force);
  list.colour_start = state.get<std::uint32_t>(name + "_colour_start");
  if (list.second.size() != list.size() || list.normal_force.size() != list.size() ||
      list.tangential_force.size() != list.size() || list.rolling_force.size() != list.size())
    throw std::runtime_error("state: the columns of " + name + " differ in length");
}

void put_ledger(const core::EnergyLedger& ledger, State& state) {
  std::vector<double> numbers = {ledger.kinetic_j, ledger.potential_j, ledger.elastic_j,
                                 ledger.stored_at_start_j, ledger.throughput_j};
  numbers.insert(numbers.end(), ledger.channels_j.begin(), ledger.channels_j.end());
  state.put("ledger", "J", numbers);
}

void get_ledger(const State& state, core::EnergyLedger& ledger) {
  const std::vector<double> numbers = state.get<double>("ledger");
  if (numbers.size() != 5 + ledger.channels_j.size())
    throw std::runtime_error("state: the ledger has another number of channels");
  ledger.kinetic_j = numbers[0];
  ledger.potential_j = numbers[1];
  ledger.elastic_j = numbers[2];
  ledger.stored_at_start_j = numbers[3];
  ledger.throughput_j = numbers[4];
  std::copy(numbers.begin() + 5, numbers.end(), ledger.channels_j.begin());
}

// The contacts of a list that carry force, between disks that are kept (new_index >= 0).
dda::CandidateList carrying(const dda::CandidateList& list,
                            const std::vector<std::int32_t>& new_index, bool second_is_disk) {
  dda::CandidateList kept;
  for (std::size_t s = 0; s < list.size(); ++s) {
    if (list.normal_force[s] == 0) continue;
    const std::int32_t first = new_index[static_cast<std::size_t>(list.first[s])];
    const std::int32_t second =
        second_is_disk ? new_index[static_cast<std::size_t>(list.second[s])] : list.second[s];
    if (first < 0 || second < 0) continue;
    kept.first.push_back(first);
    kept.second.push_back(second);
    kept.normal_force.push_back(list.normal_force[s]);
    kept.tangential_force.push_back(list.tangential_force[s]);
    kept.rolling_force.push_back(list.rolling_force[s]);
  }
  return kept;
}

}  // namespace

core::State store_filling(const dda::System& system, const dda::BucketGeometry& bucket,
                          std::size_t placed_count, bool settled) {
  dda::Disks kept;
  std::vector<std::int32_t> new_index(system.disks.count() + 1, -1);
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    if (!disk_in_bucket(system, bucket, k)) continue;
    new_index[k] = static_cast<std::int32_t>(kept.count());
    const double inverse_mass = system.disks.motion[k].inverse_mass;
    kept.add(system.disks.pose[k], {0, 0, 0, inverse_mass}, system.disks.stratum[k]);
    kept.id.back() = system.disks.id[k];
  }
  State state;
  put_disks(kept, state);
  put_list("pairs", carrying(system.lists.pairs, new_index, true), state);
  put_list("walls", carrying(system.lists.walls, new_index, false), state);
  state.put_scalar("placed_count", "1", static_cast<std::uint64_t>(placed_count));
  state.put_scalar("stiffness", "N/m", system.contact.stiffness);
  state.put_scalar("settled", "1", static_cast<std::uint8_t>(settled));
  return state;
}

void load_filling(const State& state, dda::System& system) {
  get_disks(state, system.disks);
  dda::reset_contacts(system);
  get_list(state, "pairs", system.lists.pairs);
  get_list(state, "walls", system.lists.walls);
}

void store_system(const dda::System& system, State& state) {
  put_disks(system.disks, state);
  put_list("pairs", system.lists.pairs, state);
  put_list("walls", system.lists.walls, state);
  const dda::NeighbourLists::Reference& reference = system.lists.reference();
  state.put("list_searched", "1", reference.searched);
  put_records<dda::Vec2>(state, "list_position", "m, m", reference.position);
  put_records<dda::Vec2>(state, "list_velocity", "m/s, m/s", reference.velocity);
  put_records<dda::Vec2>(state, "list_wall_position", "m, m", reference.wall_position);
  put_records<dda::Vec2>(state, "list_wall_position_fixed", "m, m", reference.wall_position_fixed);
  state.put("list_clearance", "m", reference.clearance);
  state.put("list_clearance_fixed", "m", reference.clearance_fixed);
  state.put("list_numbers", "s, s, m, m, m",
            std::vector<double>{reference.age, reference.horizon, reference.cell, reference.reach,
                                system.lists.skin()});
  state.put("touched", "1", system.touched);
  state.put("system_numbers", "N/m, s, s, rad/s, J, m",
            std::vector<double>{system.contact.stiffness, system.time_step, system.time,
                                system.drive.rotation_rate, system.report.kinetic_energy,
                                system.report.worst_overlap});
  const dda::StepCounters& c = system.counters;
  state.put("system_counters", "1",
            std::vector<std::uint64_t>{
                c.steps, c.disk_steps, c.sweeps, c.contact_updates, c.unconverged_steps,
                system.belt_runs ? 1u : 0u, system.report.contacts, c.open_close_iterations,
                c.linear_iterations, c.penalty_growths, system.ledger_is_new ? 1u : 0u,
                c.drag_evaluations, c.effects.rotation, c.effects.history, c.effects.cohesion,
                c.effects.rolling});
  put_records<dda::DiskAcceleration>(state, "contact_acceleration", "m/s2, m/s2, m/s2",
                                     system.contact_acceleration);
  put_ledger(system.ledger, state);
}

void load_system(const State& state, dda::System& system) {
  get_disks(state, system.disks);
  get_list(state, "pairs", system.lists.pairs);
  get_list(state, "walls", system.lists.walls);
  dda::NeighbourLists::Reference reference;
  reference.searched = state.get<std::uint32_t>("list_searched");
  get_records<dda::Vec2>(state, "list_position", reference.position);
  get_records<dda::Vec2>(state, "list_velocity", reference.velocity);
  get_records<dda::Vec2>(state, "list_wall_position", reference.wall_position);
  get_records<dda::Vec2>(state, "list_wall_position_fixed", reference.wall_position_fixed);
  reference.clearance = state.get<double>("list_clearance");
  reference.clearance_fixed = state.get<double>("list_clearance_fixed");
  const auto list_numbers = state.get<double>("list_numbers");
  const auto numbers = state.get<double>("system_numbers");
  const auto counters = state.get<std::uint64_t>("system_counters");
  if (list_numbers.size() != 5 || numbers.size() != 6 || counters.size() != 16)
    throw std::runtime_error("state: it comes from another version");
  reference.age = list_numbers[0];
  reference.horizon = list_numbers[1];
  reference.cell = list_numbers[2];
  reference.reach = list_numbers[3];
  system.lists.restore(reference);
  system.lists.set_skin(list_numbers[4]);
  dda::note_masses(system);
  system.touched = state.get<std::uint8_t>("touched");
  system.contact.stiffness = numbers[0];
  system.time_step = numbers[1];
  system.time = numbers[2];
  system.drive.rotation_rate = numbers[3];
  system.report.kinetic_energy = numbers[4];
  system.report.worst_overlap = numbers[5];
  system.counters = {counters[0],  counters[1],
                     counters[2],  counters[3],
                     counters[4],  counters[7],
                     counters[8],  counters[9],
                     counters[11], {counters[12], counters[13], counters[14], counters[15]}};
  system.ledger_is_new = counters[10] != 0;
  get_records<dda::DiskAcceleration>(state, "contact_acceleration", system.contact_acceleration);
  system.belt_runs = counters[5] != 0;
  system.report.contacts = counters[6];
  get_ledger(state, system.ledger);
}

void store_record(const DischargeRecord& record, State& state) {
  state.put("record_counts", "1",
            std::vector<std::uint64_t>{record.placed_count, record.initial_count,
                                       record.ended ? 1u : 0u, record.settled ? 1u : 0u});
  state.put("record_numbers", "kg, 1, deg, 1, kg",
            std::vector<double>{record.initial_mass, record.rademacher_ka, record.next_sample_deg,
                                record.remaining_at_end, record.discharged_mass});
  state.put("sample_time", "s", record.sample_time);
  state.put("sample_angle", "deg", record.sample_angle_deg);
  state.put("sample_remaining", "1", record.sample_remaining);
  state.put("sample_cg_x", "m", record.sample_cg_x);
  state.put("sample_cg_y", "m", record.sample_cg_y);
  state.put("landing_x", "m", record.landing_x);
  state.put("landed_inside", "1", record.landed_inside);
  state.put("in_target", "1", record.in_target);
  put_records<measure::FlyingDisk>(state, "flying_at_end", "m, m, kg", record.flying_at_end);
}

void load_record(const State& state, DischargeRecord& record) {
  const auto counts = state.get<std::uint64_t>("record_counts");
  const auto numbers = state.get<double>("record_numbers");
  if (counts.size() != 4 || numbers.size() != 5)
    throw std::runtime_error("state: it comes from another version");
  record.placed_count = counts[0];
  record.initial_count = counts[1];
  record.ended = counts[2] != 0;
  record.settled = counts[3] != 0;
  record.initial_mass = numbers[0];
  record.rademacher_ka = numbers[1];
  record.next_sample_deg = numbers[2];
  record.remaining_at_end = numbers[3];
  record.discharged_mass = numbers[4];
  record.sample_time = state.get<double>("sample_time");
  record.sample_angle_deg = state.get<double>("sample_angle");
  record.sample_remaining = state.get<double>("sample_remaining");
  record.sample_cg_x = state.get<double>("sample_cg_x");
  record.sample_cg_y = state.get<double>("sample_cg_y");
  record.landing_x = state.get<double>("landing_x");
  record.landed_inside = state.get<std::uint8_t>("landed_inside");
  record.in_target = state.get<std::uint8_t>("in_target");
  get_records<measure::FlyingDisk>(state, "flying_at_end", record.flying_at_end);
}

core::State DischargeSimulation::snapshot() const {
  State state;
  store_system(system_, state);
  store_record(record_, state);
  state.put("scenario", "1, s, 1, J",
            std::vector<double>{static_cast<double>(phase_), phase_start_,
                                static_cast<double>(phase_steps_), peak_kinetic_energy_});
  if (filling_)
    for (const core::Column& column : filling_->columns) {
      state.put(column);
      state.columns.back().name = kFillingPrefix + column.name;
    }
  return state;
}

void DischargeSimulation::restore(const State& state) {
  load_system(state, system_);
  load_record(state, record_);
  const auto scenario = state.get<double>("scenario");
  if (scenario.size() != 4) throw std::runtime_error("state: it comes from another version");
  phase_ = static_cast<DischargePhase>(static_cast<int>(scenario[0]));
  choose_books();
  choose_solver();
  phase_start_ = scenario[1];
  phase_steps_ = static_cast<std::uint64_t>(scenario[2]);
  peak_kinetic_energy_ = scenario[3];
  filling_.reset();
  for (const core::Column& column : state.columns) {
    if (!column.name.starts_with(kFillingPrefix)) continue;
    if (!filling_) filling_.emplace();
    filling_->put(column);
    filling_->columns.back().name = column.name.substr(kFillingPrefix.size());
  }
}

}  // namespace granary::scene
