// The lists of disk pairs and disk-wall pairs that may touch before the next search, and when they
// are due again. At a search each disk's path is predicted: a disk that touched something keeps its
// velocity relative to the bucket, a free one flies its parabola. The lists hold until the horizon
// passes or some disk strays from its predicted path by a quarter of the skin. So disks at rest in
// the turning bucket and disks in flight never make them stale.
#pragma once

#include <vector>

#include "worker/dda/belt_drive.h"
#include "worker/dda/colouring.h"
#include "worker/dda/contact_list.h"
#include "worker/dda/disks.h"
#include "worker/dda/pair_search.h"
#include "worker/dda/walls.h"

namespace granary::dda {

struct PredictedPath {
  double x = 0, y = 0, vx = 0, vy = 0, ax = 0, ay = 0;
};

struct SearchFrame {
  RigidVelocity bucket;   // velocity of the bucket now
  RigidPose bucket_pose;  // position of the bucket now
  double gravity = 0;
  double time_step = 0;
};

class NeighbourLists {
 public:
  CandidateList pairs;
  CandidateList walls;  // second = wall segment

  void set_skin(double skin) { skin_ = skin; }
  double skin() const { return skin_; }
  // Counts one step; `disks` as they are at its end.
  void note_step(const Disks& disks, double time_step);
  bool stale() const { return !valid_; }
  void rebuild(const Disks& disks, const std::vector<std::uint8_t>& touched, const Walls& walls,
               const SearchFrame& frame);
  std::uint64_t rebuild_count() const { return rebuild_count_; }

  // State of the prediction, for checkpoints.
  struct Reference {
    std::vector<PredictedPath> path;
    std::uint64_t age_steps = 0;
    double age = 0;  // s
    std::uint64_t horizon_steps = 8;
    bool valid = false;
  };
  Reference reference() const { return {path_, age_steps_, age_, horizon_steps_, valid_}; }
  void restore(const Reference& reference);

 private:
  void predict(const Disks& disks, const std::vector<std::uint8_t>& touched,
               const SearchFrame& frame);
  void find_walls(const Disks& disks, const Walls& walls, const SearchFrame& frame, double horizon,
                  std::vector<NewContact>& found) const;

  double skin_ = 0;
  std::vector<PredictedPath> path_;
  std::uint64_t age_steps_ = 0;
  double age_ = 0;
  std::uint64_t horizon_steps_ = 8;
  bool valid_ = false;
  std::uint64_t rebuild_count_ = 0;
  PairSearch search_;
  std::vector<SweptDisk> swept_;
  std::vector<DiskPair> found_pairs_;
  std::vector<NewContact> found_;
};

}  // namespace granary::dda
