// Hard cases of the DDA engine. Masses: 4 mm disks of 730 kg/m2 weigh 9.2 g per metre of depth, so
// K = 1e7 N/m and dt = 2e-4 s make K dt^2 / m = 44.
#include "tests/stability/case_lists.h"

namespace granary::stability {
namespace {

using testing::velocity_becomes_nan;
using testing::velocity_jumps_by;

// 120 disks thrown from a small straight bucket.
const std::string kBucket = R"(
seed: 1
discharge {
  particles { count: 120 diameter_min_m: 0.0035 diameter_max_m: 0.0045 density_kg_per_m3: 730 }
  bucket { shape: STRAIGHT tip_x_m: -0.06 tip_y_m: 0.06 }
  friction_pp_deg: 47
  friction_pw_deg: 34
  rotation_rad_per_s: 8.9
}
effects { gas: OFF }
)";

// Disks of 4 mm placed by hand over a floor at y = 0, 0.2 s.
std::string placed(
    const std::string& disks, const std::string& more = "",
    const std::string& walls = "points { x_m: -1 y_m: 0 } points { x_m: 1 y_m: 0 }") {
  return "discharge { filling: EXPLICIT no_bucket: true duration_s: 0.2\n"
         "particles { density_kg_per_m3: 730 } friction_pp_deg: 20 friction_pw_deg: 20\n" +
         disks + "\nwalls { " + walls + " }\n" + more + "}\neffects { gas: OFF }\n";
}

std::string disk(double x_mm, double y_mm, const std::string& more = "", double diameter_mm = 4) {
  return "discs { x_m: " + std::to_string(x_mm * 1e-3) + " y_m: " + std::to_string(y_mm * 1e-3) +
         " diameter_m: " + std::to_string(diameter_mm * 1e-3) + " " + more + " }\n";
}

// Disks in two layers over a floor between two walls 40 mm apart.
std::string tray() {
  std::string disks;
  for (int k = 0; k < 8; ++k) disks += disk(4 + 4.5 * k, 2.5) + disk(5 + 4.1 * k, 7);
  return placed(disks, "",
                "points { x_m: 0 y_m: 0.05 } points { x_m: 0 y_m: 0 } points { x_m: 0.04 y_m: 0 } "
                "points { x_m: 0.04 y_m: 0.05 }");
}

HardCase bucket(const std::string& name, std::vector<FieldSetting> settings,
                End end = End::complete, const std::string& diagnosis = "") {
  return {name, kBucket, std::move(settings), end, diagnosis};
}

void add_penalties_and_steps(std::vector<HardCase>& cases) {
  const std::string stiffness = "discharge.penalty.stiffness_n_per_m";
  cases.push_back(bucket("dda_penalty_1e3", {{stiffness, "1e3"}}, End::recovered, stiffness));
  cases.push_back(bucket("dda_penalty_1e4", {{stiffness, "1e4"}}));
  cases.push_back(bucket("dda_penalty_1e5", {{stiffness, "1e5"}}));
  cases.push_back(
      bucket("dda_penalty_1e9", {{stiffness, "1e9"}, {"discharge.end_angle_deg", "60"}}));
  cases.push_back(bucket("dda_penalty_1e12",
                         {{stiffness, "1e12"}, {"discharge.end_angle_deg", "20"}}, End::recovered,
                         "the integrator added"));
  cases.push_back(bucket("dda_step_tiny", {{"discharge.time_step_s", "2e-6"},
                                           {"discharge.end_angle_deg", "20"},
                                           {"discharge.filling_time_step_s", "2e-4"}}));
  cases.push_back(
      bucket("dda_step_10_times_too_big",
             {{"discharge.time_step_s", "2e-3"}, {"discharge.filling_time_step_s", "2e-4"}},
             End::recovered, "discharge.time_step_s"));
  cases.push_back(bucket("dda_filling_step_2e_3", {{"discharge.filling_time_step_s", "2e-3"}},
                         End::recovered, "overlap"));
  cases.push_back(bucket("dda_step_out_of_range", {{"discharge.time_step_s", "0.02"}}, End::refused,
                         "discharge.time_step_s"));
  cases.push_back(
      bucket("dda_soft_filling_stiff_run", {{"discharge.filling_stiffness_n_per_m", "1e5"}}));
  cases.push_back(
      bucket("dda_very_soft_filling_stiff_run", {{"discharge.filling_stiffness_n_per_m", "1e4"}}));
}

void add_motion(std::vector<HardCase>& cases) {
  cases.push_back(bucket("dda_500_rpm", {{"discharge.rotation_rad_per_s", "52.36"}}));
  cases.push_back(bucket("dda_belt_speed_at_once", {{"discharge.initial_velocity", "BELT"}}));
  std::string resting;
  for (int k = 0; k < 10; ++k)
    resting += disk(-500 - 3 - 4.2 * k, 5 + 6.5 * k) + disk(-500 - 3 - 4.2 * k, 30 + 6.5 * k);
  cases.push_back(
      {"dda_walls_start_at_full_speed",
       "discharge { filling: EXPLICIT rotation_rad_per_s: 8.9 time_step_s: 1e-3\n"
       "bucket { shape: STRAIGHT tip_x_m: -0.08 tip_y_m: 0.08 }\n"
       "particles { density_kg_per_m3: 730 } friction_pp_deg: 20 friction_pw_deg: 20\n" +
           resting + "}\neffects { gas: OFF }\n",
       {},
       End::recovered,
       "overlap"});
  cases.push_back(bucket("dda_one_disk", {{"discharge.particles.count", "1"}}));
  cases.push_back(bucket("dda_no_disk", {{"discharge.particles.count", "0"}}, End::refused,
                         "discharge.particles.count"));
  cases.push_back(bucket(
      "dda_blocked_outlet",
      {{"discharge.bucket.deflector_m", "0.09"}, {"discharge.bucket.deflector_angle_deg", "75"}},
      End::refused, "discharge.bucket.deflector_m"));
  cases.push_back(bucket(
      "dda_nearly_blocked_outlet",
      {{"discharge.bucket.deflector_m", "0.06"}, {"discharge.bucket.deflector_angle_deg", "60"}}));
}

void add_materials(std::vector<HardCase>& cases) {
  cases.push_back(bucket("dda_friction_0",
                         {{"discharge.friction_pp_deg", "0"}, {"discharge.friction_pw_deg", "0"}}));
  cases.push_back(bucket("dda_friction_5", {{"discharge.friction_pp_deg", "78.69"},
                                            {"discharge.friction_pw_deg", "78.69"}}));
  cases.push_back(bucket("dda_restitution_1", {{"discharge.normal_restitution", "1"}}));
  cases.push_back(bucket("dda_restitution_0_01", {{"discharge.normal_restitution", "0.01"}}));
  cases.push_back(bucket("dda_size_ratio_50",
                         {{"discharge.particles.diameter_min_m", "0.0002"},
                          {"discharge.particles.diameter_max_m", "0.01"},
                          {"discharge.particles.count", "60"},
                          {"discharge.end_angle_deg", "60"}},
                         End::recovered));
  cases.push_back(bucket("dda_sizes_1_to_6_mm_no_friction_1e9",
                         {{"discharge.particles.diameter_min_m", "0.001"},
                          {"discharge.particles.diameter_max_m", "0.006"},
                          {"discharge.friction_pp_deg", "0"},
                          {"discharge.friction_pw_deg", "0"},
                          {"discharge.penalty.stiffness_n_per_m", "1e9"},
                          {"discharge.end_angle_deg", "60"}},
                         End::recovered, "overlap"));
  cases.push_back(bucket("dda_cohesion_100_times_weight", {{"discharge.cohesion_n_per_m", "9"}}));
  cases.push_back({"dda_mass_ratio_1e6",
                   placed(disk(0, 0.501, "", 1) + disk(30, 0.501, "", 1) +
                          disk(15, 501, "vy_m_per_s: -0.1", 1000)),
                   {{"discharge.penalty.stiffness_n_per_m", "1e9"},
                    {"discharge.solver.method", "OPEN_CLOSE"}}});
  cases.push_back({"dda_mass_ratio_1e6_by_sweeps",
                   placed(disk(0, 0.501, "", 1) + disk(30, 0.501, "", 1) +
                          disk(15, 501, "vy_m_per_s: -0.1", 1000)),
                   {{"discharge.penalty.stiffness_n_per_m", "1e9"}},
                   End::unstable,
                   "discharge.solver.method OPEN_CLOSE"});
}

void add_single_contacts(std::vector<HardCase>& cases) {
  cases.push_back({"dda_two_disks_in_one_place",
                   placed(disk(0, 10) + disk(0, 10)),
                   {},
                   End::refused,
                   "discharge.discs"});
  cases.push_back({"dda_deep_initial_overlap",
                   placed(disk(0, 10) + disk(1.9, 10)),
                   {},
                   End::refused,
                   "discharge.discs"});
  cases.push_back({"dda_initial_overlap_of_0_4_radii", placed(disk(0, 10) + disk(3.2, 10)), {}});
  cases.push_back({"dda_wedge_of_5_deg",
                   placed(disk(0, 80, "vy_m_per_s: -3"), "",
                          "points { x_m: -0.0043661 y_m: 0.1 } points { x_m: 0 y_m: 0 } "
                          "points { x_m: 0.0043661 y_m: 0.1 }"),
                   {}});
  const std::string jointed =
      "points { x_m: -1 y_m: 0 } points { x_m: 0 y_m: 0 } "
      "points { x_m: 1 y_m: 0 }";
  cases.push_back({"dda_joint_hit_exactly", placed(disk(0, 30), "", jointed), {}});
  cases.push_back({"dda_inner_corner_hit_exactly",
                   placed(disk(2.5, 20, "vx_m_per_s: -1 vy_m_per_s: -1"), "",
                          "points { x_m: 0 y_m: 1 } points { x_m: 0 y_m: 0 } "
                          "points { x_m: 1 y_m: 0 }"),
                   {}});
  cases.push_back({"dda_edge_hit_exactly",
                   placed(disk(0, 30), "",
                          "points { x_m: -0.1 y_m: -0.1 } points { x_m: 0 y_m: 0 } "
                          "points { x_m: 0.1 y_m: -0.1 }"),
                   {}});
  cases.push_back({"dda_grazing_impact", placed(disk(-300, 2.2, "vx_m_per_s: 5")), {}});
  cases.push_back({"dda_100_m_per_s_on_thin_wall",
                   placed(disk(0, 51, "vy_m_per_s: -100")),
                   {{"discharge.duration_s", "0.01"}}});
  cases.push_back({"dda_100_m_per_s_head_on",
                   placed(disk(-30, 50, "vx_m_per_s: 100") + disk(30, 50, "vx_m_per_s: -100")),
                   {{"discharge.duration_s", "0.01"}}});
}

void add_methods(std::vector<HardCase>& cases) {
  cases.push_back(bucket("dda_open_close_chatters",
                         {{"discharge.solver.method", "OPEN_CLOSE"},
                          {"discharge.penalty.growth_factor", "1"},
                          {"discharge.end_angle_deg", "30"}},
                         End::recovered, "did not settle"));
  cases.push_back(bucket("dda_open_close_one_iteration",
                         {{"discharge.solver.method", "OPEN_CLOSE"},
                          {"discharge.solver.max_iterations", "1"},
                          {"discharge.end_angle_deg", "10"}},
                         End::unstable, "discharge.solver.method IMPULSE"));
  cases.push_back(bucket("dda_penalty_growth",
                         {{"discharge.solver.method", "OPEN_CLOSE"},
                          {"discharge.penalty.stiffness_n_per_m", "1e5"},
                          {"discharge.time_step_s", "5e-4"},
                          {"discharge.filling_time_step_s", "2e-4"},
                          {"discharge.end_angle_deg", "60"}},
                         End::recovered, "did not settle"));
  cases.push_back(bucket("dda_penalty_growth_at_2e_3",
                         {{"discharge.solver.method", "OPEN_CLOSE"},
                          {"discharge.penalty.stiffness_n_per_m", "1e5"},
                          {"discharge.time_step_s", "2e-3"},
                          {"discharge.filling_time_step_s", "2e-4"},
                          {"discharge.end_angle_deg", "60"}},
                         End::recovered, "discharge.time_step_s"));
  // What a few steps leave that do not settle is not booked.
  cases.back().largest_remainder = 5e-3;
  cases.push_back(
      {"dda_trapezoid_at_kappa_100",
       placed(disk(0, 22), "solver { integrator: NEWMARK_TRAPEZOID } time_step_s: 3e-4\n"),
       {},
       End::recovered,
       "only dissipate"});
}

void add_meddling(std::vector<HardCase>& cases) {
  HardCase once = bucket("dda_nan_injected_once", {}, End::recovered, "finite");
  once.meddling = {{700, 0, 1, velocity_becomes_nan()}};
  cases.push_back(once);
  HardCase always =
      bucket("dda_nan_injected_again_and_again", {}, End::unstable, "no longer finite");
  always.meddling = {{700, 0, 100, velocity_becomes_nan()}};
  cases.push_back(always);
  HardCase pushed{"dda_pushed_by_no_force",
                  tray(),
                  {{"discharge.duration_s", "0.4"}},
                  End::unstable,
                  "missing from the ledger"};
  pushed.meddling = {{100, 100, 1000000, velocity_jumps_by(0.5)}};
  cases.push_back(pushed);
}

}  // namespace

std::vector<HardCase> discharge_cases() {
  std::vector<HardCase> cases;
  add_penalties_and_steps(cases);
  add_motion(cases);
  add_materials(cases);
  add_single_contacts(cases);
  add_methods(cases);
  add_meddling(cases);
  return cases;
}

}  // namespace granary::stability
