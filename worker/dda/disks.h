// The disks: two records of four doubles each, so that a contact kernel fetches one disk with one
// 32-byte load. Lengths m, masses kg for the whole axial depth of the scene.
//
// Spin is kept as the surface speed r * w (w > 0 counter-clockwise). For a disk (I = m r^2 / 2) a
// tangential impulse P changes it by 2 P / m, so radius and inertia drop out of the contact law.
//
// One resting record follows the last disk (`rest_index`): inverse mass 0 and a negative radius. It
// stands for every wall and pads the kernels' unused lanes; nothing ever changes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/dda/aligned_vector.h"

namespace granary::dda {

struct alignas(32) DiskPose {
  double x = 0;
  double y = 0;
  double radius = 0;
  double angle = 0;  // rad, counter-clockwise
};

struct alignas(32) DiskMotion {
  double vx = 0;
  double vy = 0;
  double surface_speed = 0;  // radius * spin
  double inverse_mass = 0;
};

// What a disk has moved since the start of a step.
struct alignas(32) DiskShift {
  double x = 0;
  double y = 0;
  double surface = 0;  // radius * angle
  double unused = 0;
};

struct Disks {
  AlignedVector<DiskPose> pose;        // count() + 1 records
  AlignedVector<DiskMotion> motion;    // count() + 1 records
  std::vector<std::uint32_t> id;       // as placed; survives removals
  std::vector<std::uint32_t> stratum;  // row of the filling array, for pictures
  std::vector<std::uint8_t> landed;    // 1: fell below the landing level, touches nothing any more

  Disks() { append_rest_record(); }
  std::size_t count() const { return id.size(); }
  std::int32_t rest_index() const { return static_cast<std::int32_t>(count()); }

  void add(const DiskPose& new_pose, const DiskMotion& new_motion, std::uint32_t new_stratum) {
    pose.back() = new_pose;
    motion.back() = new_motion;
    id.push_back(static_cast<std::uint32_t>(id.size()));
    stratum.push_back(new_stratum);
    landed.push_back(0);
    append_rest_record();
  }

  void append_rest_record() {
    pose.push_back({0, 0, -1e6, 0});
    motion.push_back({0, 0, 0, 0});
  }
};

}  // namespace granary::dda
