// The one interface between an engine and everything that runs, stores and shows simulations.
// A simulation owns its whole scenario (filling, rotation, feed, end). It is advanced in chunks,
// and neither the chunk size nor the number of threads may change a single bit of what it computes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "worker/core/column.h"
#include "worker/core/energy_ledger.h"

namespace granary::core {

// What kind of failure it is: decides which setting is changed (worker/run/recovery.h).
enum class Cause : std::uint8_t { other, overlap, speed, not_finite, not_converged, energy };

// A numerical failure is data: what happened, when, to whom, and what the user can change.
struct Rejection {
  double time_s = 0;
  std::string reason;
  std::vector<std::int64_t> ids;
  std::string suggestion;  // names the field to change
  Cause cause = Cause::other;
};

// One numerical setting that a run may change by itself to get past a failure.
enum class Remedy : std::uint8_t {
  halve_time_step,    // the state goes on
  tighten_tolerance,  // of the contact solver, tenfold; the state goes on
  raise_penalty       // tenfold, from the very beginning: under load it would add energy
};

struct SettingChange {
  std::string path;  // of the scene
  double before = 0;
  double after = 0;
};

enum class AdvanceStatus {
  advanced,  // stopped at the limit of the chunk
  finished,  // the scenario is over; observe() holds the final values
  rejected   // sentinels tripped and the bounded recovery of the engine did not help
};

struct AdvanceOutcome {
  AdvanceStatus status = AdvanceStatus::advanced;
  std::optional<Rejection> rejection;  // set when rejected
};

struct SimulationProgress {
  double fraction = 0;  // 0..1 of the whole run, filling included
  std::string phase;
  double time_s = 0;  // simulated, of the main phase; negative during filling
  double end_time_s = 0;
  std::uint64_t steps = 0;           // all phases
  std::uint64_t particle_steps = 0;  // free particles only
  std::size_t particles = 0;
  std::size_t contacts = 0;
  std::vector<std::pair<std::string, double>> current_values;
};

struct ObservedValue {
  std::string name;  // key of `values`, unit last: "f1_m"
  std::string unit;
  std::optional<double> value;  // absent = unknown
  std::optional<double> error;  // half-width of the 95 % interval
  std::string error_basis;      // how the error was found, or why there is none
};

// Columns of equal length. A series has "time_s" first.
struct Table {
  std::string name;
  std::vector<Column> columns;
};

struct Observation {
  std::vector<ObservedValue> values;
  std::vector<Table> series;
  std::vector<Table> fields;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::uint64_t>> effect_evaluations;  // 0 proves "off"
};

struct PhaseSeconds {
  std::string phase;  // "neighbour lists", "contacts", "integration", ...
  double seconds = 0;
};

class Simulation {
 public:
  virtual ~Simulation() = default;

  // Advances until progress().time_s >= until_time_s (steps are never shortened to hit it), the
  // scenario ends, or max_steps steps are done.
  virtual AdvanceOutcome advance(double until_time_s, std::uint64_t max_steps) = 0;

  virtual SimulationProgress progress() const = 0;
  virtual const EnergyLedger& ledger() const = 0;

  // Valid at any time; final after `finished`.
  virtual Observation observe() const = 0;

  // One frame for people and pictures: position_m, velocity_m_per_s, radius_m, id, ... Views stay
  // valid until the next call of a non-const member.
  virtual std::vector<ColumnView> frame() const = 0;

  // The physical state whose hash identifies the result: every bit that a rerun must reproduce.
  virtual std::vector<ColumnView> physical_state() const = 0;

  // Everything, contact history and random numbers included; restore() on a simulation made from
  // the same input continues bitwise. Throws std::runtime_error on a state of another simulation.
  virtual State snapshot() const = 0;
  virtual void restore(const State& state) = 0;

  // Steps between two marks: states that the run layer checks in full and can go back to. Fixed by
  // the scene, because what is gone back to decides bits; a snapshot should cost below 1 % of them.
  virtual std::uint64_t steps_between_marks() const { return 256; }

  // Steps so far whose contacts were not solved to the tolerance; explicit engines have none.
  virtual std::uint64_t unconverged_steps() const { return 0; }

  // Changes one setting from now on: right after restore(), or, before it, on a simulation made
  // anew to take over a state that was saved after the same change. raise_penalty: only on one made
  // anew.
  virtual bool knows(Remedy) const { return false; }
  virtual SettingChange apply(Remedy) { return {}; }

  // The settled filling, for reuse by other simulations that ask for the same one; nullopt when
  // this simulation has none (yet).
  virtual std::optional<State> stored_filling() const { return std::nullopt; }

  virtual std::vector<PhaseSeconds> profile() const { return {}; }
};

}  // namespace granary::core
