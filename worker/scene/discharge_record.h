// What a discharge run remembers for its results: samples once a degree, the instant each disk
// falls below the landing level, and the flight values at the end of the half turn.
#pragma once

#include <cstdint>
#include <optional>
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
  bool ended = false;                       // the end angle was reached
  std::vector<measure::FlyingDisk> flying_at_end;
  double remaining_at_end = 0;
  double discharged_mass = 0;  // kg
};

bool disk_in_bucket(const dda::System& system, const dda::BucketGeometry& bucket, std::size_t disk);

// Takes a sample if the rotation has passed the next whole degree (or `force`).
void sample_discharge(const dda::System& system, const dda::BucketGeometry& bucket, bool force,
                      DischargeRecord& record);

// Marks disks that fell below `level` during the last step.
void note_landings(dda::System& system, const dda::BucketGeometry& bucket, double level,
                   DischargeRecord& record);

// The instant t_e of f1..f4.
void close_record(const dda::System& system, const dda::BucketGeometry& bucket,
                  DischargeRecord& record);

std::vector<measure::FlyingDisk> landed_disks(const dda::System& system,
                                              const DischargeRecord& record);

}  // namespace granary::scene
