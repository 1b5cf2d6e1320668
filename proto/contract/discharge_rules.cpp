#include "proto/contract/discharge_rules.h"

#include <cmath>
#include <vector>

#include "proto/contract/placement_rules.h"
#include "proto/contract/rule_text.h"

namespace granary {
namespace {

std::optional<Error> check_discs(const v1::Discharge& discharge) {
  std::vector<Placed> bodies;
  for (int k = 0; k < discharge.discs_size(); ++k) {
    const v1::Disc& disc = discharge.discs(k);
    bodies.push_back({{disc.x_m(), disc.y_m(), 0}, disc.diameter_m() / 2, k});
  }
  return check_placement("discharge.discs", std::move(bodies));
}

// Horizontal clearance of the bucket mouth: a disk that does not fit in can never be filled in.
std::optional<double> mouth_width(const v1::Bucket& bucket) {
  const double tip_y = bucket.has_tip_y_m() ? bucket.tip_y_m() : 0.4;
  if (bucket.shape() == v1::Bucket::POLYLINE) {
    if (bucket.points_size() < 2) return {};
    return -bucket.points(bucket.points_size() - 1).x_m();
  }
  if (bucket.has_opening_angle_deg())
    return tip_y * std::tan(bucket.opening_angle_deg() * M_PI / 180);
  return bucket.has_tip_x_m() ? -bucket.tip_x_m() : 0.4;
}

std::optional<Error> check_bucket(const v1::Discharge& discharge, double largest) {
  const v1::Bucket& bucket = discharge.bucket();
  if (bucket.shape() == v1::Bucket::POLYLINE && bucket.points_size() < 2)
    return refuse("discharge.bucket.points", "needs at least 2 points for shape POLYLINE");
  if (bucket.shape() == v1::Bucket::BEZIER)
    for (const auto& [name, there] :
         {std::pair{"x2_m", bucket.has_x2_m()}, std::pair{"x3_m", bucket.has_x3_m()},
          std::pair{"x4_m", bucket.has_x4_m()}})
      if (!there)
        return refuse(std::string("discharge.bucket.") + name, "is missing, shape BEZIER needs it");
  const auto width = mouth_width(bucket);
  const double covered = bucket.deflector_m() * std::sin(bucket.deflector_angle_deg() * M_PI / 180);
  if (width && covered > 0 && *width - covered < 1.5 * largest)
    return refuse("discharge.bucket.deflector_m", "covers " + number(covered) +
                                                      " m of a mouth of " + number(*width) +
                                                      " m, must leave >= " + number(1.5 * largest) +
                                                      " m (1.5 diameters of the largest disk)");
  const char* field = bucket.shape() == v1::Bucket::POLYLINE ? "discharge.bucket.points"
                      : bucket.has_opening_angle_deg()       ? "discharge.bucket.opening_angle_deg"
                                                             : "discharge.bucket.tip_x_m";
  if (width && *width < 1.5 * largest)
    return refuse(field, "makes a mouth of " + number(*width) +
                             " m, must be >= " + number(1.5 * largest) +
                             " m (1.5 diameters of the largest disk, " + number(largest) + " m)");
  return {};
}

}  // namespace

std::optional<Error> check_discharge(const v1::Discharge& discharge) {
  const bool placed = discharge.filling() == v1::Discharge::EXPLICIT;
  if (placed && discharge.discs_size() == 0)
    return refuse("discharge.discs", "is empty, filling EXPLICIT needs at least one");
  if (placed)
    if (auto error = check_discs(discharge)) return error;
  if (!placed && discharge.no_bucket())
    return refuse("discharge.no_bucket",
                  "needs filling EXPLICIT: without a bucket there is nothing to fill");
  const auto& particles = discharge.particles();
  const double smallest = particles.diameter_min_m();
  const double largest = particles.has_diameter_max_m() ? particles.diameter_max_m() : smallest;
  if (!placed && largest < smallest)
    return refuse("discharge.particles.diameter_max_m",
                  "= " + number(largest) +
                      " is out of range, must be >= diameter_min_m = " + number(smallest));
  if (discharge.has_rotation_rad_per_s() && discharge.has_rademacher_ka())
    return refuse("discharge.rademacher_ka", "stands beside rotation_rad_per_s, give one of them");
  if (!discharge.has_rotation_rad_per_s() && !discharge.has_rademacher_ka() &&
      !discharge.has_duration_s())
    return refuse("discharge.rotation_rad_per_s",
                  "is missing, must be >= 0 and <= 500 (or give rademacher_ka, or duration_s for a "
                  "bucket at rest)");
  if (discharge.has_rotation_rad_per_s() && discharge.rotation_rad_per_s() == 0 &&
      !discharge.has_duration_s())
    return refuse("discharge.duration_s",
                  "is missing: with rotation_rad_per_s = 0 the end angle is never reached");
  if (discharge.filling() == v1::Discharge::STORED && discharge.stored_filling().empty())
    return refuse("discharge.stored_filling",
                  "is missing, filling STORED needs the job it comes from");
  if (discharge.filling() != v1::Discharge::STORED && discharge.has_stored_filling())
    return refuse("discharge.stored_filling",
                  "= " + discharge.stored_filling() + " stands without discharge.filling: STORED");
  if (discharge.target_size() == 1 || discharge.target_size() == 2)
    return refuse("discharge.target", "needs at least 3 points to enclose an opening");
  for (int i = 0; i < discharge.walls_size(); ++i)
    if (discharge.walls(i).points_size() < 2)
      return refuse("discharge.walls[" + std::to_string(i) + "].points", "needs at least 2 points");
  if (discharge.no_bucket()) return {};
  return check_bucket(discharge, placed ? 0 : largest);
}

}  // namespace granary
