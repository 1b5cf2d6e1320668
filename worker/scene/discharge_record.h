// What a discharge run remembers for its results: samples once a degree, the instant each disk
// falls below the landing level, and the flight values at the end of the half turn.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/dda/bucket.h"
#include "worker/dda/system.h"
#include "worker/measure/discharge_values.h"

namespace granary::scene {

struct DischargeRecord {
  std::size_t placed_count = 0;   // N, before the filling
  std::size_t initial_count = 0;  // N0
  double initial_mass = 0;        // kg
  double rademacher_ka = 0;
  bool settled = true;  // the filling came to rest

  std::vector<double> sample_time, sample_angle_deg, sample_remaining, sample_cg_x, sample_cg_y;
  double next_sample_deg = 0;

  std::vector<double> landing_x;            // per disk, NaN until it lands
  std::vector<std::uint8_t> landed_inside;  // per disk: still in the bucket as it passed the level
  std::vector<std::uint8_t> in_target;      // per disk: its path has entered the target
  bool ended = false;                       // the end angle was reached
  std::vector<measure::FlyingDisk> flying_at_end;
  double remaining_at_end = 0;
  double discharged_mass = 0;  // kg
};

bool disk_in_bucket(const dda::System& system, const dda::BucketGeometry& bucket, std::size_t disk);

// Takes a sample if the rotation has passed the next whole degree (or `force`).
void sample_discharge(const dda::System& system, const dda::BucketGeometry& bucket, bool force,
                      DischargeRecord& record);

// Notes disks that fell below `level` during the last step, and takes those out of the contacts
// that fell below `floor`, too.
struct LandingLevels {
  double level = 0;  // y of the landing values
  double floor = 0;  // <= level: nothing below it matters any more
};
void note_landings(dda::System& system, const dda::BucketGeometry& bucket,
                   const LandingLevels& levels, DischargeRecord& record);

// Notes disks outside the bucket whose path of the last step entered the target.
void note_target(const dda::System& system, const dda::BucketGeometry& bucket,
                 std::span<const dda::Vec2> target, DischargeRecord& record);

// Where the discharged disks end up, as numbers of disks.
struct LandingShares {
  std::size_t target = 0;  // entered the target
  std::size_t leg = 0;     // left the bucket and fell past the level without it
};
LandingShares landing_shares(const DischargeRecord& record);

// 1 for disks outside the bucket that still fly.
void mark_flying(const dda::System& system, const dda::BucketGeometry* bucket,
                 std::vector<std::uint8_t>& flying);

// The instant t_e of f1..f4.
void close_record(const dda::System& system, const dda::BucketGeometry& bucket,
                  DischargeRecord& record);

std::vector<measure::FlyingDisk> landed_disks(const dda::System& system,
                                              const DischargeRecord& record);

}  // namespace granary::scene
