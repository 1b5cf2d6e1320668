// The DEM step written for reading: one grain after the other, all options tested at run time,
// double precision, one thread. It is the oracle that the block engine is compared with, and runs
// what that one cannot: double precision and turning walls. Its result does not depend on when its
// neighbour list was built: contacts are visited in the order of the grain ids.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/core/cell_grid.h"
#include "worker/core/column.h"
#include "worker/core/energy_ledger.h"
#include "worker/core/simulation.h"
#include "worker/dem/body_terms.h"
#include "worker/dem/engine.h"
#include "worker/dem/pair_coefficients.h"
#include "worker/dem/surface_mesh.h"
#include "worker/dem/trouble.h"

namespace granary::dem {

class PlainEngine final : public Engine {
 public:
  // Precondition: at least one class, 0 < time_step <= stable_time_step(setup).
  explicit PlainEngine(const EngineSetup& setup);

  std::int64_t insert(std::span<const Grain> grains) override;
  void release(std::int64_t first, std::int64_t end) override;
  void set_gravity(const core::Vec3& gravity) override;
  void advance(std::uint64_t steps) override;
  void halve_time_step() override;

  std::uint64_t step() const override { return step_; }
  double time() const override { return static_cast<double>(step_) * setup_.time_step; }
  std::size_t grain_count() const override { return bodies_.size(); }
  std::size_t contact_count() const override { return contacts_.size(); }
  std::uint64_t particle_steps() const override { return particle_steps_; }
  EffectCounts effect_counts() const override;
  double largest_overlap_ratio() const override { return largest_overlap_ratio_; }
  const EngineSetup& setup() const override { return setup_; }

  GrainTable grains() const override;
  std::vector<Leaver> take_leavers() override;
  const core::EnergyLedger& ledger() const override { return ledger_; }
  const std::optional<core::Rejection>& trouble() const override { return trouble_; }

  core::State snapshot() const override;
  void restore(const core::State& state) override;

 private:
  struct Body {
    core::Vec3 position;       // at the full step, engine axes
    core::Vec3 velocity_half;  // half a step earlier
    core::Vec3 spin_half;
    core::Vec3 carried_velocity;  // chute axes, while carried
    core::Vec3 force;
    core::Vec3 torque;
    core::Vec3 velocity_mean;  // over the last kick, for the ledger
    core::Vec3 spin_mean;
    std::int64_t id = 0;
    std::uint8_t grain_class = 0;
    bool carried = false;
    bool fresh = true;  // its first overlaps enter the ledger through the inlet
  };
  struct Candidate {
    std::int32_t first = 0;
    std::int32_t second = 0;  // < 0: wall -1 - second; beyond the planes: a slot for the mesh
    std::int64_t first_id = 0;
    std::int64_t second_id = 0;  // of a wall: same as `second`
    core::Vec3 spring = {};
    core::Vec3 velocity = {};  // relative, of the last step; while touching
    SurfaceTouch touch = {};   // mesh only, engine axes
    bool touching = false;
    bool is_met = false;  // mesh only: touched in this step
    bool is_wall() const { return second < 0; }
    std::size_t wall() const { return static_cast<std::size_t>(-1 - second); }
  };
  // A grain near the mesh: the triangles in its reach, and the first of its kMostTouches
  // candidates.
  struct Surroundings {
    std::size_t candidate = 0;
    std::uint32_t begin = 0, end = 0;  // in near_triangles_
  };
  struct Contact {
    std::size_t candidate = 0;
    ContactGeometry geometry;
    ContactForce force;
  };

  void restore_scalars(const core::State& state);
  void step_once();
  void refresh_candidates();
  bool candidates_are_stale() const;
  std::vector<Candidate> collect_candidates();
  void add_neighbours_of(std::size_t a, std::span<const core::Vec3> points,
                         const core::CellGrid& grid, std::vector<Candidate>& list) const;
  void add_walls_of(std::size_t a, const core::Vec3& point, std::vector<Candidate>& list) const;
  void add_surface_of(std::size_t a, const core::Vec3& point, std::vector<Candidate>& list);
  void place_walls();
  void touch_mesh();
  SurfaceTouch wall_touch(const Candidate& candidate) const;
  bool find_contact(const Candidate& candidate, ContactGeometry& geometry) const;
  void predict(const Candidate& candidate, ContactGeometry& geometry) const;
  void sum_forces();
  void meet(std::size_t candidate_index);
  bool is_prescribed(const Candidate& candidate) const;
  void part(Candidate& candidate, const ContactGeometry& geometry);
  void integrate();
  void carry(Body& body);
  void let_leavers_go();
  void log_if_leaving(const Body& body);
  void watch();
  std::vector<std::int64_t> deepest_ids() const;
  double path_ratio(const Body& body) const;  // of a step in the chute's axes / radius

  const GrainClass& class_of(const Body& body) const { return setup_.classes[body.grain_class]; }
  const ContactCoefficients& law_of(const Candidate& candidate) const;
  double spin_response_of(const Candidate& candidate) const;

  enum class Moment { mean_of_kick, after_kick };
  struct Relative {
    core::Vec3 velocity;
    core::Vec3 spin;
  };
  Relative relative(const Contact& contact, Moment moment) const;
  void book_step();
  void book_contact(const Contact& contact, double span);
  void book_drive(const Contact& contact, double span);
  void book_first_overlap(const Contact& contact);
  void book(core::EnergyChannel channel, double energy) { book_into(ledger_, channel, energy); }
  void update_stored();
  double kinetic_energy(const Body& body) const;
  double potential_energy(const Body& body) const;
  void book_transfer(core::EnergyChannel channel, const Body& body, double sign);
  double normal_energy(const ContactCoefficients& law, double overlap) const;
  double elastic_energy(const Contact& contact) const;

  EngineSetup setup_;
  BodyTerms terms_;
  PairCoefficients coefficients_;
  core::Mat3 spring_turn_;  // rotation of the chute in one step, engine axes
  core::Mat3 half_turn_;    // and in half a step
  double skin_ = 0;

  std::vector<Body> bodies_;  // ascending ids
  std::vector<Candidate> candidates_;
  std::vector<core::Vec3> listed_at_;  // chute axes, when the candidates were collected
  SurfaceMesh mesh_;
  std::vector<Surroundings> near_mesh_;
  std::vector<std::uint32_t> near_triangles_;
  std::vector<SurfaceMesh::Foot> feet_;  // scratch
  std::vector<Contact> contacts_;
  std::vector<Plane> walls_now_;  // engine axes
  FrameMap map_;                  // at the current time
  bool list_is_void_ = true;
  std::uint64_t step_ = 0;
  std::int64_t next_id_ = 0;
  std::uint64_t particle_steps_ = 0;
  std::uint64_t contact_evaluations_ = 0;
  double largest_overlap_ratio_ = 0;
  std::vector<Leaver> leavers_;
  core::EnergyLedger ledger_;
  std::optional<core::Rejection> trouble_;
};

}  // namespace granary::dem
