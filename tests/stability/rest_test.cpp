// Claim: what lies still stays where it is. A deep pile does not creep, however long one waits.
// Method: a filled bucket at rest (DDA) and a settled closed tray (DEM), watched for a time that is many
//   thousand contact times; the first part is given to what is left of the settling.
// Reference: no motion.
// Tolerance: 1e-3 diameters over the watch. A disk that crept at the speed of a pack held with a loose
//   tolerance (1.2e-3 m/s, PHYSICS section F) would miss it by 4000 after 15 s.
// Seconds: 4. GRANARY_REST_S sets the seconds watched (60 for the full length).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "proto/contract/resolve.h"
#include "tests/stability/hard_case.h"
#include "worker/scene/chute.h"
#include "worker/scene/discharge.h"

namespace granary::stability {
namespace {

double watched_s(double otherwise) {
  const char* text = std::getenv("GRANARY_REST_S");
  return text != nullptr ? std::atof(text) : otherwise;
}

std::vector<double> positions(const core::Simulation& simulation) {
  for (const core::ColumnView& column : simulation.frame())
    if (column.name == "position_m") {
      const auto* numbers = static_cast<const double*>(column.data);
      return {numbers, numbers + column.rows * column.width};
    }
  return {};
}

// Rows of a frame may change places between two frames of the DEM engine.
std::vector<std::int64_t> ids(const core::Simulation& simulation) {
  std::vector<std::int64_t> found;
  for (const core::ColumnView& column : simulation.frame()) {
    if (column.name != "id") continue;
    for (std::size_t k = 0; k < column.rows; ++k)
      found.push_back(column.type == core::ElementType::u32
                          ? static_cast<const std::uint32_t*>(column.data)[k]
                          : static_cast<const std::int64_t*>(column.data)[k]);
  }
  return found;
}

double largest_shift(const core::Simulation& simulation, const std::vector<double>& before,
                     const std::vector<std::int64_t>& ids_before) {
  const std::vector<double> now = positions(simulation);
  const std::vector<std::int64_t> ids_now = ids(simulation);
  const std::size_t width = now.size() / ids_now.size();
  std::map<std::int64_t, std::size_t> row;
  for (std::size_t k = 0; k < ids_now.size(); ++k) row[ids_now[k]] = k;
  double largest = 0;
  for (std::size_t k = 0; k < ids_before.size(); ++k) {
    double square = 0;
    for (std::size_t i = 0; i < width; ++i) {
      const double d = now[row.at(ids_before[k]) * width + i] - before[k * width + i];
      square += d * d;
    }
    largest = std::max(largest, std::sqrt(square));
  }
  return largest;
}

void run_until(core::Simulation& simulation, double time_s) {
  for (;;) {
    const core::AdvanceOutcome outcome = simulation.advance(time_s, 1'000'000);
    ASSERT_NE(outcome.status, core::AdvanceStatus::rejected) << outcome.rejection->reason;
    if (outcome.status == core::AdvanceStatus::finished || simulation.progress().time_s >= time_s)
      return;
  }
}

v1::Scene resolved(const std::string& text) {
  const auto scene = load_scene(text, "rest.txtpb", {});
  EXPECT_TRUE(scene) << scene.error().message;
  return resolve(*scene)->scene;
}

void expect_rest(core::Simulation& simulation, double from_s, double to_s, double diameter_m) {
  run_until(simulation, from_s);
  const std::vector<double> before = positions(simulation);
  const std::vector<std::int64_t> ids_before = ids(simulation);
  ASSERT_FALSE(before.empty());
  run_until(simulation, to_s);
  EXPECT_LT(largest_shift(simulation, before, ids_before), 1e-3 * diameter_m);
}

TEST(Rest, deep_bucket_of_disks_does_not_creep) {
  const double seconds = watched_s(15);
  const auto simulation = scene::make_discharge(
      resolved("discharge { particles { count: 60 diameter_min_m: 0.0035 diameter_max_m: 0.0045 "
               "density_kg_per_m3: 730 } bucket { shape: STRAIGHT tip_x_m: -0.03 tip_y_m: 0.09 } "
               "friction_pp_deg: 20 friction_pw_deg: 20 rotation_rad_per_s: 0 duration_s: " +
               std::to_string(seconds + 0.5) + " } effects { gas: OFF }"),
      nullptr);
  expect_rest(*simulation, 0.5, 0.5 + seconds, 0.004);
}

// Without spin: beads that roll give way long after they have come to lie, and the rolling torque, which
// is proportional to spin up to its limit, holds them with a creep of mu_r R F dt R / I (1e-5 m/s here).
TEST(Rest, deep_tray_of_beads_does_not_creep) {
  constexpr double kSettlingSeconds = 2;
  const double seconds = watched_s(1.5);
  const std::string contact =
      "{ normal_stiffness_n_per_m: 1000 normal_restitution: 0.5 tangential_restitution: 0.3 "
      "friction_coefficient: 0.4 }";
  const auto simulation = scene::make_chute(
      resolved("chute { length_m: 0.012 width_m: 0.012 inclination_deg: 0 closed_end: true "
               "inlet { feed: NONE } initial_count: 100 particles { diameter_m: 0.003 "
               "density_kg_per_m3: 2550 } contact_pp " +
               contact + " contact_pw " + contact +
               " duration_s: " + std::to_string(seconds + kSettlingSeconds) + " } effects { gas: OFF particle_rotation: OFF }"),
      nullptr);
  expect_rest(*simulation, kSettlingSeconds, kSettlingSeconds + seconds, 0.003);
}

}  // namespace
}  // namespace granary::stability
