// Claim: the base case of the chute paper (30 deg, 0 rpm, gas off) flows as in two other codes.
// Method: chute_base_30deg at full size, means over 1.5 s once it is steady.
// Reference: tests/reference, LAMMPS and LIGGGHTS, same cells and windows (PHYSICS section H), x >=
// 0.05 m. Tolerance: surface velocity 0.5 %, bed height 0.5 mm, depth profile of speed 2 %,
// count 29.4k +- 2 %,
//   mass flux 1.6 kg/s +- 0.5 % (three times what the two codes differ by: 0.15 %, 0.24 mm, 0.9 %
//   in count). The flux of a window of 30 mm swings by 1 % from frame to frame: its 95 % interval
//   is added.
// Seconds: 65
#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/papers/chute_means.h"
#include "tests/support/shipped_scenes.h"

namespace granary::tests {
namespace {

constexpr double kFirstX = 0.05;  // upstream of it the falling inlet column decides, m

std::vector<CsvRow> reference(const std::string& what) {
  return read_csv(std::string(GRANARY_REFERENCE) + "/chute_30deg_0rpm_" + what + "_lammps.csv");
}

void check_surface_velocity(const ChuteMeans& means) {
  std::size_t compared = 0;
  for (const CsvRow& row : reference("streamwise")) {
    const double x = row.at("x_centre_m");
    if (x < kFirstX) continue;
    const double expected = row.at("u_surface_top6_m_s");
    EXPECT_NEAR(means.surface_velocity(x), expected, 0.005 * expected) << "x = " << x;
    ++compared;
  }
  EXPECT_EQ(compared, 18U);
}

void check_bed_height(const ChuteMeans& means) {
  for (const CsvRow& row : reference("height")) {
    const double x = row.at("x_centre_m");
    if (x < kFirstX) continue;
    EXPECT_NEAR(means.bed_height(x, 0.0175), row.at("h_y17.5mm_m"), 0.0005) << "x = " << x;
    EXPECT_NEAR(means.bed_height(x, 0.0475), row.at("h_y47.5mm_m"), 0.0005) << "x = " << x;
    EXPECT_NEAR(means.bed_height(x, 0.0675), row.at("h_y67.5mm_m"), 0.0005) << "x = " << x;
  }
}

void check_depth_profile(const ChuteMeans& means) {
  const std::vector<ChuteMeans::DepthBin> bins = means.depth_profile();
  std::size_t compared = 0;
  for (const CsvRow& row : reference("depth")) {
    if (row.at("solid_fraction") < 0.1) continue;
    for (const ChuteMeans::DepthBin& bin : bins) {
      if (std::abs(bin.x - row.at("x_m")) > 1e-6) continue;
      if (std::abs(bin.height - row.at("z_mid_m")) > 1e-6) continue;
      EXPECT_NEAR(bin.streamwise, row.at("u_m_s"), 0.02 * row.at("u_m_s"))
          << "x = " << bin.x << ", z = " << bin.height;
      ++compared;
    }
  }
  EXPECT_GE(compared, 28U);
}

void check_count(const ChuteMeans& means) {
  EXPECT_NEAR(means.value("particle_count").value, 29400, 0.02 * 29400);
}

void check_mass_flux(const ChuteMeans& means) {
  for (const char* name :
       {"mass_flow_kg_per_s", "mass_flow_x200mm_kg_per_s", "mass_flow_x400mm_kg_per_s",
        "mass_flow_x600mm_kg_per_s", "mass_flow_x800mm_kg_per_s"}) {
    const Mean flux = means.value(name);
    EXPECT_NEAR(flux.value, 1.6, 0.005 * 1.6 + flux.error) << name;
    EXPECT_LT(flux.error, 0.02 * 1.6) << name;
  }
}

// PHYSICS A6: energy balance of a plug that slips on its base, no free parameter, 1 %.
void check_plug_slip(const ChuteMeans& means) {
  const double angle = M_PI / 6, x = 0.8, inlet = 0.2732;
  const double expected =
      std::sqrt(inlet * inlet + 2 * 9.81 * (std::sin(angle) - 0.22 * std::cos(angle)) * x);
  double sum = 0, grains = 0;
  for (const ChuteMeans::DepthBin& bin : means.depth_profile()) {
    if (std::abs(bin.x - 0.8) > 1e-6) continue;
    sum += bin.streamwise * bin.solid_fraction;
    grains += bin.solid_fraction;
  }
  EXPECT_NEAR(sum / grains, expected, 0.01 * expected);
}

void check_ledger(const ChuteMeans& means) {
  EXPECT_LT(means.ledger_remainder(), 1e-4);
}

// One run, one test: a run takes a minute.
TEST(ChuteBaseCase, flows_as_in_two_other_codes) {
  const ChuteMeans means = ChuteMeans::of_run(shipped_scene(
      "chute_base_30deg", {{"chute.duration_s", "2.7"}, {"chute.sample_start_s", "1.2"}}));
  check_surface_velocity(means);
  check_bed_height(means);
  check_depth_profile(means);
  check_count(means);
  check_mass_flux(means);
  check_plug_slip(means);
  check_ledger(means);
}

}  // namespace
}  // namespace granary::tests
