// Hard cases of the DEM engine. 3 mm beads of 2550 kg/m3 weigh 0.035 g; with k_n = 1000 N/m a
// contact lasts 0.42 ms and an impact of 1 m/s goes 0.09 radii deep.
#include "tests/stability/case_lists.h"

namespace granary::stability {
namespace {

using testing::velocity_becomes_nan;
using testing::velocity_jumps_by;

std::string contact(double stiffness, double restitution, double friction) {
  return "{ normal_stiffness_n_per_m: " + std::to_string(stiffness) +
         " normal_restitution: " + std::to_string(restitution) +
         " tangential_restitution: 0.33 friction_coefficient: " + std::to_string(friction) + " }\n";
}

struct Material {
  double stiffness = 1000;
  double restitution = 0.9;
  double friction = 0.3;
};

// Beads placed by hand in a short chute: floor, two side walls 80 mm apart.
std::string placed(
    const std::string& beads, const Material& m = {}, const std::string& more = "",
    const std::string& particles = "particles { diameter_m: 0.003 density_kg_per_m3: 2550 }",
    double length_m = 0.2) {
  return "chute { length_m: " + std::to_string(length_m) +
         " inclination_deg: 0 duration_s: 0.2 closed_end: true\n" + particles + "\ncontact_pp " +
         contact(m.stiffness, m.restitution, m.friction) + "contact_pw " +
         contact(m.stiffness, m.restitution, m.friction) + "inlet { feed: NONE }\n" + beads + more +
         "}\neffects { gas: OFF }\n";
}

std::string bead(double x_mm, double y_mm, double z_mm, const std::string& more = "") {
  return "beads { x_m: " + std::to_string(x_mm * 1e-3) + " y_m: " + std::to_string(y_mm * 1e-3) +
         " z_m: " + std::to_string(z_mm * 1e-3) + " " + more + " }\n";
}

// 80 settled beads in a closed tray.
std::string bed(const Material& m = {}, const std::string& more = "") {
  return placed("initial_count: 80\n", m, "width_m: 0.02\n" + more,
                "particles { diameter_m: 0.003 density_kg_per_m3: 2550 }", 0.03);
}

void add_stiffness_and_steps(std::vector<HardCase>& cases) {
  const std::string drop = bead(20, 40, 50);
  const std::string advice = "contact_pp.normal_stiffness_n_per_m";
  cases.push_back({"dem_stiffness_10", placed(drop, {.stiffness = 10}), {}, End::unstable, advice});
  cases.push_back({"dem_stiffness_1e3", placed(drop, {.stiffness = 1e3}), {}});
  cases.push_back({"dem_stiffness_1e6", placed(drop, {.stiffness = 1e6}), {}});
  cases.push_back({"dem_stiffness_1e10",
                   placed(bead(20, 40, 1.6, "vz_m_per_s: -1"), {.stiffness = 1e10}),
                   {{"chute.duration_s", "0.0005"}}});
  cases.push_back({"dem_step_10_times_too_big",
                   placed(drop, {}, "time_step_s: 1e-4\n"),
                   {},
                   End::refused,
                   "chute.time_step_s"});
  cases.push_back({"dem_step_at_the_limit",
                   placed(drop, {}, "time_step_s: 8e-5\n"),
                   {},
                   End::recovered,
                   "missing from the ledger"});
  cases.push_back({"dem_step_tiny",
                   placed(bead(20, 40, 1.6, "vz_m_per_s: -1")),
                   {{"chute.time_step_s", "1e-8"}, {"chute.duration_s", "0.001"}}});
}

void add_sizes(std::vector<HardCase>& cases) {
  const auto two = [](double small_mm, double large_mm, double small_density,
                      double large_density) {
    return "particles { diameter_m: " + std::to_string(small_mm * 1e-3) +
           " density_kg_per_m3: " + std::to_string(small_density) +
           " mass_fraction: 0.5 } particles { diameter_m: " + std::to_string(large_mm * 1e-3) +
           " density_kg_per_m3: " + std::to_string(large_density) + " mass_fraction: 0.5 }";
  };
  cases.push_back(
      {"dem_mass_ratio_1e6",
       placed(bead(50, 40, 0.3, "particle_class: 0") + bead(50.2, 40, 15.7, "particle_class: 1"),
              {.stiffness = 1e5}, "", two(0.6, 30, 1000, 8000)),
       {{"chute.duration_s", "0.01"}}});
  cases.push_back(
      {"dem_size_ratio_50",
       placed(bead(50, 40, 0.35, "particle_class: 0") + bead(50.3, 40, 15.8, "particle_class: 1"),
              {.stiffness = 1e5}, "", two(0.6, 30, 2550, 2550)),
       {{"chute.duration_s", "0.02"}}});
  cases.push_back({"dem_size_ratio_60",
                   placed(bead(50, 40, 20, "particle_class: 1"), {}, "", two(0.5, 30, 2550, 2550)),
                   {},
                   End::refused,
                   "size ratio"});
}

void add_single_contacts(std::vector<HardCase>& cases) {
  cases.push_back({"dem_two_beads_in_one_place",
                   placed(bead(20, 40, 5) + bead(20, 40, 5)),
                   {},
                   End::refused,
                   "chute.beads"});
  cases.push_back({"dem_deep_initial_overlap",
                   placed(bead(20, 40, 5) + bead(21, 40, 5)),
                   {},
                   End::refused,
                   "chute.beads"});
  cases.push_back(
      {"dem_initial_overlap_of_0_4_radii", placed(bead(20, 40, 5) + bead(22.4, 40, 5)), {}});
  cases.push_back(
      {"dem_starts_inside_the_floor", placed(bead(20, 40, 0.2)), {}, End::unstable, "overlap"});
  cases.push_back(
      {"dem_corner_hit_exactly", placed(bead(20, 4, 4, "vy_m_per_s: -1 vz_m_per_s: -1")), {}});
  cases.push_back({"dem_wedge_of_5_deg",
                   placed(bead(50, 40, 60, "vz_m_per_s: -1"), {.stiffness = 1e5},
                          "no_walls: true\n"
                          "planes { point_m: 0.05 point_m: 0.04 point_m: 0 "
                          "normal: 0 normal: 0.999048 normal: 0.043619 }\n"
                          "planes { point_m: 0.05 point_m: 0.04 point_m: 0 "
                          "normal: 0 normal: -0.999048 normal: 0.043619 }\n"),
                   {{"chute.closed_end", "false"}}});
  cases.push_back({"dem_grazing_impact",
                   placed(bead(10, 40, 1.6, "vx_m_per_s: 5")),
                   {{"chute.length_m", "1"}}});
  cases.push_back({"dem_100_m_per_s_on_soft_wall",
                   placed(bead(20, 40, 20, "vz_m_per_s: -100")),
                   {{"chute.duration_s", "0.01"}},
                   End::unstable,
                   "chute.contact_pp.normal_stiffness_n_per_m"});
  cases.push_back({"dem_100_m_per_s_on_stiff_wall",
                   placed(bead(20, 40, 20, "vz_m_per_s: -100"), {.stiffness = 1e7}),
                   {{"chute.duration_s", "0.001"}}});
}

void add_materials(std::vector<HardCase>& cases) {
  cases.push_back({"dem_restitution_0_01", bed({.restitution = 0.01}), {}});
  cases.push_back({"dem_restitution_0", bed({.restitution = 0}), {}});
  cases.push_back({"dem_restitution_1", bed({.restitution = 1}), {}});
  cases.push_back({"dem_friction_0", bed({.friction = 0}), {}});
  cases.push_back({"dem_friction_5", bed({.friction = 5}), {}});
  cases.push_back({"dem_cohesion_100_times_weight", bed({}, "cohesion_bond: 100\n"), {}});
}

void add_scenes(std::vector<HardCase>& cases) {
  const std::string feed =
      "inlet { feed: LATTICE mass_flow_kg_per_s: 0.02 sluice_height_m: 0.009 }\n";
  const auto fed = [&](const std::string& more, double stiffness = 1000) {
    return "chute { length_m: 0.06 width_m: 0.02 inclination_deg: 30 duration_s: 0.3\n"
           "particles { diameter_m: 0.003 density_kg_per_m3: 2550 }\ncontact_pp " +
           contact(stiffness, 0.9, 0.3) + "contact_pw " + contact(stiffness, 0.9, 0.3) + feed +
           more + "}\neffects { gas: OFF }\n";
  };
  cases.push_back({"dem_one_bead", placed(bead(20, 40, 30)), {}});
  cases.push_back({"dem_no_bead", placed(""), {}});
  // 4 mm in a step: without a look at speeds it would pass the wall of triangles untouched.
  cases.push_back({"dem_bullet_at_a_mesh",
                   placed(bead(22, 40, 30, "vx_m_per_s: 400"), {},
                          "triangles { vertices_m: [0.1, 0, 0, 0.1, 0.08, 0, 0.1, 0.04, 0.2] }\n"),
                   {},
                   End::unstable,
                   "normal_stiffness_n_per_m"});
  cases.push_back({"dem_blocked_outlet", fed("closed_end: true\n"), {}});
  // 56 g of centrifugal acceleration at 0.2 m: impacts of several metres per second.
  cases.push_back({"dem_500_rpm_soft",
                   fed("rotation_rpm: 500\n"),
                   {},
                   End::unstable,
                   "normal_stiffness_n_per_m"});
  cases.push_back({"dem_500_rpm", fed("rotation_rpm: 500\n", 3e5), {{"chute.duration_s", "0.15"}}});
  cases.push_back({"dem_500_rpm_inertial",
                   fed("rotation_rpm: 500 frame: INERTIAL\n", 3e5),
                   {{"chute.duration_s", "0.15"}}});
  cases.push_back({"dem_no_gravity", fed("gravity_m_per_s2: 0\n"), {}});
  cases.push_back({"dem_feed_too_fast",
                   fed(""),
                   {{"chute.inlet.mass_flow_kg_per_s", "50"}},
                   End::refused,
                   "chute.inlet.mass_flow_kg_per_s"});
}

void add_meddling(std::vector<HardCase>& cases) {
  HardCase once{"dem_nan_injected_once", bed(), {}, End::recovered, "not"};
  once.meddling = {{9000, 0, 1, velocity_becomes_nan()}};
  cases.push_back(once);
  HardCase always{"dem_nan_injected_again_and_again", bed(), {}, End::unstable, "not"};
  always.meddling = {{9000, 0, 100, velocity_becomes_nan()}};
  cases.push_back(always);
  HardCase pushed{"dem_pushed_by_no_force",
                  placed(bead(20, 40, 1.51)),
                  {},
                  End::unstable,
                  "missing from the ledger"};
  pushed.meddling = {{100, 100, 1000000, velocity_jumps_by(0.05)}};
  cases.push_back(pushed);
}

}  // namespace

std::vector<HardCase> chute_cases() {
  std::vector<HardCase> cases;
  add_stiffness_and_steps(cases);
  add_sizes(cases);
  add_single_contacts(cases);
  add_materials(cases);
  add_scenes(cases);
  add_meddling(cases);
  return cases;
}

const std::vector<HardCase>& hard_cases() {
  static const std::vector<HardCase> cases = [] {
    std::vector<HardCase> all = discharge_cases();
    for (HardCase& chute : chute_cases()) all.push_back(std::move(chute));
    return all;
  }();
  return cases;
}

}  // namespace granary::stability
