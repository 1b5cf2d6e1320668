// The lists of disk pairs and disk-wall pairs that may touch, and how long they hold. Both are
// judged in the bucket's frame. The pair list holds every pair that comes closer than the skin
// within a horizon if the disks keep their velocities; it is due again after the horizon, or when
// neighbours may have strayed against each other by the skin less the speculative margin
// (motion_groups.h). The wall list holds until some disk has moved, against the walls, through the
// clearance that the search found for it. So neither the turning bucket nor disks in flight make
// the lists stale, however fast they are.
#pragma once

#include <vector>

#include "worker/dda/colouring.h"
#include "worker/dda/contact_list.h"
#include "worker/dda/disks.h"
#include "worker/dda/motion_groups.h"
#include "worker/dda/pair_search.h"
#include "worker/dda/walls.h"

namespace granary::dda {

struct SearchFrame {
  RigidPose bucket;       // now
  RigidPose bucket_next;  // at the end of the coming step
  double time_step = 0;
  double margin_ratio = 0;  // speculative margin / (r_i + r_k)
};

class NeighbourLists {
 public:
  CandidateList pairs;
  CandidateList walls;  // second = wall segment

  void set_skin(double skin) { skin_ = skin; }
  double skin() const { return skin_; }
  // Before a step: renews what the step could outrun.
  void refresh(const Disks& disks, const Walls& walls, const SearchFrame& frame);
  std::uint64_t rebuild_count() const { return rebuild_count_; }

  // Where the disks were when the lists were built, for checkpoints.
  struct Reference {
    std::vector<std::uint32_t> searched;                   // disks of the pair search
    std::vector<Vec2> position, velocity;                  // of these, bucket frame
    std::vector<Vec2> wall_position, wall_position_fixed;  // of all disks; bucket frame, world
    std::vector<double> clearance, clearance_fixed;        // m, per disk
    double age = 0, horizon = -1;                          // s, of the pair list
    double cell = 0, reach = 0;                            // m, of the motion groups
  };
  const Reference& reference() const { return reference_; }
  void restore(const Reference& reference);

 private:
  bool pairs_hold(const Disks& disks, const SearchFrame& frame);
  bool walls_hold(const Disks& disks, const SearchFrame& frame) const;
  void note_reference(const Disks& disks, const SearchFrame& frame);
  void rebuild_pairs(const Disks& disks, const SearchFrame& frame);
  void rebuild_walls(const Disks& disks, const Walls& walls, const SearchFrame& frame);

  double skin_ = 0;
  Reference reference_;
  MotionGroups groups_;
  std::uint64_t rebuild_count_ = 0;
  // Scratch of a rebuild.
  PairSearch search_;
  std::vector<SearchDisk> search_disks_;
  std::vector<DiskPair> found_pairs_;
  std::vector<NewContact> found_;
  std::vector<Vec2> vectors_;
};

}  // namespace granary::dda
