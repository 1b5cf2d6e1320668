// The fast engine: mixed precision, vector kernels, threads. Grains are kept in cell order and cut
// into blocks of whole slabs across the stream. A step visits block after block, contacts then
// motion, so that a block is worked on while it sits in cache; one thread takes several steps at
// once along a skewed front. What block b waits for is fixed (contacts: motion of b and b + 1 in
// the step before; motion: contacts of b - 1 and b), and so are all sums: any schedule gives the
// same bits.
//
// Lists have two levels. The outer list holds pairs closer than a skin; it is good while no grain
// has strayed too far from the mean motion of its block. The inner list is pruned from it every
// `horizon` steps: pairs that could meet within the horizon, moving on as they do, or by a margin
// more. Pairs that met outside the inner list are counted (late_contacts) and widen the margin.
#pragma once

#include "worker/dem/body_terms.h"
#include "worker/dem/cell_order.h"
#include "worker/dem/crew.h"
#include "worker/dem/engine.h"
#include "worker/dem/kernels.h"
#include "worker/dem/law_tables.h"
#include "worker/dem/mesh_contact.h"
#include "worker/dem/pair_coefficients.h"
#include "worker/dem/slot_list.h"
#include "worker/dem/trouble.h"

namespace granary::dem {

class BlockEngine final : public Engine {
 public:
  // What the kernels do not cover: turning walls, double precision, predicted velocities,
  // combinations of effects without a kernel.
  static bool covers(const EngineSetup& setup);
  // Preconditions: covers(setup), at least one class, 0 < time_step <= stable_time_step(setup).
  // Throws std::invalid_argument for too many classes or walls.
  explicit BlockEngine(const EngineSetup& setup, const Kernels& kernels = dem::kernels());

  std::int64_t insert(std::span<const Grain> grains) override;
  void release(std::int64_t first, std::int64_t end) override;
  void set_gravity(const core::Vec3& gravity) override;
  void advance(std::uint64_t steps) override;
  void halve_time_step() override;

  std::uint64_t step() const override { return step_; }
  double time() const override { return static_cast<double>(step_) * setup_.time_step; }
  std::size_t grain_count() const override { return motion_.size(); }
  std::size_t contact_count() const override;
  std::uint64_t particle_steps() const override { return particle_steps_; }
  EffectCounts effect_counts() const override;
  double largest_overlap_ratio() const override { return largest_overlap_ratio_; }
  const EngineSetup& setup() const override { return setup_; }

  GrainTable grains() const override;
  std::vector<Leaver> take_leavers() override;
  const core::EnergyLedger& ledger() const override;
  const std::optional<core::Rejection>& trouble() const override { return trouble_; }
  std::vector<core::PhaseSeconds> profile() const override;

  core::State snapshot() const override;
  void restore(const core::State& state) override;

  // Contacts first seen deeper than a first touch: the inner list had missed them.
  std::uint64_t late_contacts() const { return late_contacts_; }
  std::uint64_t order_rebuilds() const { return order_rebuilds_; }
  std::size_t inner_slots() const;
  std::size_t outer_pairs() const;

 private:
  // A wall that the block does not touch yet: how near its unlisted grains are, how fast it nears.
  struct WallRoom {
    double gap = 0;       // m, of the nearest grain outside the list
    double approach = 0;  // m/s, of the block's mean motion
  };
  // A grain that may touch the mesh while the order lasts, and the triangles in its reach.
  struct MeshRow {
    std::uint32_t grain = 0;  // place in the arrays
    std::uint32_t begin = 0, end = 0;
    double room = 0;  // m, that the grain may still move before it can touch one of them
  };
  struct Block {
    BlockRange range;
    std::uint32_t inflow = 0;        // grains that the block before may push
    LineVector<GrainLoad> outgoing;  // of this step, for the first grains of the next block
    OuterList pairs, walls;
    SlotList pair_slots, wall_slots;
    SlotList old_pair_slots, old_wall_slots;
    std::vector<std::uint32_t> survivors;
    std::vector<MeshRow> mesh_rows;
    std::vector<std::uint32_t> near_triangles;
    std::vector<MeshContact> mesh_contacts, old_mesh_contacts;  // touching, by grain
    std::vector<SurfaceMesh::Foot> feet;                        // scratch
    core::Vec3 mean_velocity;                                   // when the order was built
    std::vector<WallRoom> rooms;
    double stray = 0;       // largest distance from the mean motion at the end of the horizon
    bool is_sound = true;   // no NaN
    double path_ratio = 0;  // longest path of a step / radius
    bool has_carried = false;
    bool nears_outlet = false;
    ContactSums sums;        // since the order was built
    double inlet_work = 0;   // put in by carried grains, same span [J]
    double outlet_work = 0;  // stored in contacts that ended at the outlet, same span [J]
    std::uint64_t late = 0;
    std::vector<Leaver> leavers;
  };
  // A slot between two cell orders, by place in the arrays.
  struct KeptSlot {
    std::uint32_t first = 0, second = 0;
    History history;
  };

  // block_engine.cpp: the step
  void run_steps(std::uint64_t count);
  void run_front(std::uint64_t count, bool timed);
  void run_region(unsigned worker, std::uint64_t count);
  void meet(Block& block, LineVector<GrainLoad>& desk);
  void move(std::size_t index, std::uint64_t step, LineVector<GrainLoad>& desk);
  void book_carried(std::size_t index, const LineVector<GrainLoad>& desk);
  void clear_desks();
  void log_leavers(Block& block, std::uint64_t step);
  void gather_leavers();
  void watch();
  std::vector<std::int64_t> broken_ids() const;
  std::vector<std::int64_t> fast_ids() const;
  double path_ratio(std::size_t grain) const;  // of the last step / radius
  std::vector<std::int64_t> deepest_ids() const;
  void divide_work();
  void count_free();
  BlockArrays arrays(Block& block, LineVector<GrainLoad>& desk);

  // block_lists.cpp: lists
  void refresh_lists();
  bool order_is_valid();
  void measure_stray(Block& block) const;
  void rebuild_order();
  double largest_reach() const;
  void keep_slots(std::vector<KeptSlot>& pairs, std::vector<KeptSlot>& walls) const;
  void drop_leavers(std::vector<KeptSlot>& pairs, std::vector<KeptSlot>& walls);
  void sort_grains(std::vector<KeptSlot>& pairs, std::vector<KeptSlot>& walls);
  void cut_blocks();
  void fill_block(Block& block, std::span<const KeptSlot> pairs, std::span<const KeptSlot> walls);
  void collect_pairs(Block& block);
  void collect_walls(Block& block);
  void set_reference(Block& block);
  void prune_block(Block& block);
  // Grains beyond the outlet touch nothing any more; books what their contact still held.
  bool ends_at_outlet(Block& block, std::uint32_t first, std::uint32_t second, bool is_wall,
                      const History* known) const;
  void prune_pairs(Block& block);
  void prune_walls(Block& block);
  void note_late_contacts();
  void for_blocks(const std::function<void(Block&)>& task);

  // block_mesh.cpp
  std::vector<MeshLaw> mesh_laws() const;
  void collect_mesh(Block& block);
  static std::span<const std::uint32_t> triangles_of(const Block& block, const MeshRow& row);
  void meet_mesh(Block& block, LineVector<GrainLoad>& desk);
  void meet_row(Block& block, const MeshRow& row, std::span<const MeshContact> known,
                const TouchList& touches, LineVector<GrainLoad>& desk);
  void end_mesh_at_outlet(Block& block);
  void keep_mesh_contacts();
  void move_mesh_contacts(std::span<const std::uint32_t> place);
  void inherit_mesh_contacts(Block& block);
  void show_mesh_contacts(core::EnergyLedger& ledger) const;
  void book_first_mesh_overlaps();
  void save_mesh(core::State& state) const;
  void load_mesh(const core::State& state);

  // block_ledger.cpp
  void flush_ledger();
  void begin_ledger_span();
  void book(core::EnergyChannel channel, double energy) { book_into(ledger_, channel, energy); }
  void book_transfer(core::EnergyChannel channel, std::size_t grain, double sign);
  void book_first_overlaps();
  double mass(std::size_t grain) const { return 1 / motion_[grain].inverse_mass; }
  bool is_carried(std::size_t grain) const { return motion_[grain].free_step == 0; }
  core::Vec3 half_step_position(std::size_t grain) const;
  double kinetic_energy(std::size_t grain) const;
  double potential_energy(std::size_t grain) const;
  double centrifugal_potential(std::size_t grain) const;
  struct FieldEnergy {
    double potential = 0, centrifugal = 0;  // of free grains [J]
  };
  FieldEnergy field_energy(bool with_fresh) const;
  static void book_block(const Block& block, core::EnergyLedger& ledger);
  void book_fields(core::EnergyLedger& ledger) const;
  struct Touch {  // two grains, or a grain and a wall, as they stand; signs as in kernels_body.h
    core::Vec3 normal;
    double overlap = 0;
    core::Vec3 velocity, surface;
    const LawTables* laws = nullptr;
    std::size_t kind = 0;
  };
  Touch touch_of_pair(std::size_t a, std::size_t b) const;
  Touch touch_of_wall(std::size_t a, std::size_t wall) const;
  Touch touch_of_mesh(const MeshContact& contact) const;
  double normal_energy(const Touch& touch, double overlap) const;
  double elastic_energy(const Touch& touch, const History& history) const;
  struct Unfinished {
    double damping = 0, friction = 0;  // J
  };
  Unfinished unfinished(const Touch& touch, const History& history) const;
  void show_contacts(core::EnergyLedger& ledger) const;
  // visit(list, slot, is_fresh, touch): every inner slot.
  template <typename Visit>
  void visit_slots(Visit visit) const;

  // block_state.cpp
  void save_lists(core::State& state) const;
  void load_lists(const core::State& state);
  void load_scalars(const core::State& state);

  static constexpr std::uint64_t kLongestOrderInHorizons = 32;

  EngineSetup setup_;
  const Kernels& kernels_;
  BodyTerms terms_;
  Laws laws_;
  WallTables wall_tables_;
  SurfaceMesh mesh_;
  std::vector<MeshLaw> mesh_laws_;  // one per class
  BodyCoefficients body_;
  std::size_t combination_;  // row of kEffectCombinations
  IntegrateKernel integrate_;
  std::uint64_t horizon_;  // steps between two prunings
  double skin_;            // m
  double margin_;          // m

  LineVector<GrainMotion> motion_, sorted_motion_;
  LineVector<GrainSurface> surface_, sorted_surface_;
  // Where a worker gathers the loads of the block at hand, and of the last block of its region.
  // Zero between two blocks.
  struct Desk {
    LineVector<GrainLoad> own, last;
  };
  std::vector<Desk> desks_;
  std::vector<std::int64_t> id_;
  std::vector<std::uint8_t> class_;
  std::vector<std::uint8_t> fresh_;    // put in or set free since the order was built
  std::vector<core::Vec3> listed_at_;  // positions when the order was built
  std::vector<Block> blocks_;
  std::size_t block_count_ = 0;                  // blocks_ keeps its memory
  std::vector<MeshContact> kept_mesh_contacts_;  // while the order is rebuilt
  CellOrder cells_;

  Crew crew_;
  std::vector<std::size_t> region_start_;  // first block of each worker, and the end
  std::vector<Milestone> contacts_done_;   // of the last block of a region
  std::vector<Milestone> motion_done_;     // of the first block of a region

  bool order_is_void_ = true;
  std::uint64_t step_ = 0;
  std::uint64_t next_refresh_ = 0;
  std::uint64_t ordered_at_ = 0;  // step
  std::int64_t next_id_ = 0;
  std::uint64_t particle_steps_ = 0;
  std::uint64_t contact_evaluations_ = 0;
  std::uint64_t late_contacts_ = 0;
  std::uint64_t order_rebuilds_ = 0;
  std::size_t free_count_ = 0;
  double largest_overlap_ratio_ = 0;
  std::vector<Leaver> leavers_;
  std::optional<core::Rejection> trouble_;

  core::EnergyLedger ledger_;  // up to where the order was built
  FieldEnergy span_start_;
  mutable core::EnergyLedger shown_ledger_;

  std::uint64_t windows_ = 0;
  double list_seconds_ = 0, window_seconds_ = 0;
  double timed_contacts_ = 0, timed_motion_ = 0;  // of sampled windows
};

}  // namespace granary::dem
