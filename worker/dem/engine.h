// A DEM engine: grains, contacts, time. Two of them keep the same promises: BlockEngine is the fast
// one (mixed precision), PlainEngine the one written for reading (double, one thread, both frames).
// Neither the chunks of advance() nor the number of threads change a bit of what an engine
// computes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "worker/core/column.h"
#include "worker/core/energy_ledger.h"
#include "worker/core/simulation.h"
#include "worker/dem/grains.h"
#include "worker/dem/setup.h"

namespace granary::dem {

// How often each effect was evaluated; 0 proves that it was off.
struct EffectCounts {
  std::uint64_t tangential_history = 0;
  std::uint64_t rolling_friction = 0;
  std::uint64_t spin = 0;
  std::uint64_t cohesion = 0;
  std::uint64_t rotating_frame = 0;
};

class Engine {
 public:
  virtual ~Engine() = default;

  // Adds grains at the current time; returns the id of the first, the rest follow in order.
  virtual std::int64_t insert(std::span<const Grain> grains) = 0;
  // Frees the carried grains with first <= id < end: from now on forces move them.
  virtual void release(std::int64_t first, std::int64_t end) = 0;
  // Replaces the gravity of the setup from now on (a filling settles under another one).
  virtual void set_gravity(const core::Vec3& gravity) = 0;

  // Stops early only when trouble() is set.
  virtual void advance(std::uint64_t steps) = 0;
  // From now on with half the step: time and state go on, step numbers double, trouble() is over.
  virtual void halve_time_step() = 0;

  virtual std::uint64_t step() const = 0;
  virtual double time() const = 0;
  virtual std::size_t grain_count() const = 0;
  virtual std::size_t contact_count() const = 0;     // touching in the last step
  virtual std::uint64_t particle_steps() const = 0;  // of free grains
  virtual EffectCounts effect_counts() const = 0;
  virtual double largest_overlap_ratio() const = 0;  // overlap / radius, so far
  virtual const EngineSetup& setup() const = 0;

  virtual GrainTable grains() const = 0;
  // Grains that crossed the outlet since the last call, in order of time.
  virtual std::vector<Leaver> take_leavers() = 0;
  virtual const core::EnergyLedger& ledger() const = 0;
  // Set once a sentinel has tripped: overlap, NaN. The state is then of no use.
  virtual const std::optional<core::Rejection>& trouble() const = 0;
  virtual std::vector<core::PhaseSeconds> profile() const { return {}; }

  virtual core::State snapshot() const = 0;
  // Throws std::runtime_error when the state does not belong to an engine of this setup.
  virtual void restore(const core::State& state) = 0;
};

// The engine that runs this setup: BlockEngine where it can (BlockEngine::covers), else
// PlainEngine.
std::unique_ptr<Engine> make_engine(const EngineSetup& setup);

}  // namespace granary::dem
