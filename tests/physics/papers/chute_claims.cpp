// Runs the chute paper's matrix (30 and 40 deg x 0, 4, 8, 16 rpm) and its sweeps, and scores its
// claims: one markdown table of ours / paper / what the verdict rests on (PHYSICS section B).
// usage: chute_claims SCENES_DIR [--jobs N] [--duration S] > chute_claims.md
// Means from 1.2 s on: grains leave from 0.65 s on, the count is steady from 1.0 s. A quarter of an
// hour of CPU time at the default duration of 2.4 s.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <thread>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_text.h"
#include "tests/physics/papers/chute_means.h"

namespace {

using namespace granary;
using tests::ChuteMeans;
using tests::Mean;

constexpr double kStations[] = {0.2, 0.4, 0.6, 0.8};

struct Case {
  std::string name;
  int slope = 30;
  std::vector<FieldSetting> set;
};

std::string matrix_name(int slope, int rpm) {
  return std::to_string(slope) + " deg " + std::to_string(rpm) + " rpm";
}

std::vector<Case> cases() {
  std::vector<Case> list;
  for (const int slope : {30, 40}) {
    for (const int rpm : {0, 4, 8, 16}) {
      list.push_back(
          {matrix_name(slope, rpm), slope, {{"chute.rotation_rpm", std::to_string(rpm)}}});
    }
  }
  const auto sweep = [&](const std::string& name, const std::vector<FieldSetting>& set) {
    list.push_back({name, 30, set});
  };
  sweep("sluice 0.03", {{"chute.inlet.sluice_height_m", "0.03"}});
  sweep("sluice 0.02", {{"chute.inlet.sluice_height_m", "0.02"}});
  sweep("sluice 0.03, 16 rpm",
        {{"chute.inlet.sluice_height_m", "0.03"}, {"chute.rotation_rpm", "16"}});
  for (const char* e : {"0.1", "0.9"}) {
    sweep("e_t " + std::string(e), {{"chute.contact_pp.tangential_restitution", e},
                                    {"chute.contact_pw.tangential_restitution", e}});
  }
  for (const char* e : {"0.3", "0.99"}) {  // fixed ratio of e_n at walls and between grains
    const double wall = std::atof(e) * 0.95 / 0.97;
    sweep("e_n " + std::string(e), {{"chute.contact_pp.normal_restitution", e},
                                    {"chute.contact_pw.normal_restitution", std::to_string(wall)}});
  }
  for (const char* mu : {"0.12", "0.35"}) {
    sweep("mu " + std::string(mu), {{"chute.contact_pw.friction_coefficient", mu}});
  }
  for (const char* mu_r : {"0.05", "0.2"}) {
    sweep("mu_r " + std::string(mu_r), {{"chute.contact_pw.rolling_friction_coefficient", mu_r},
                                        {"chute.contact_pp.rolling_friction_coefficient", mu_r}});
  }
  for (const char* offset : {"0.10", "0.25"}) {
    sweep("axis " + std::string(offset),
          {{"chute.axis_offset_m", offset}, {"chute.rotation_rpm", "16"}});
  }
  sweep("measured friction", {{"chute.contact_pp.friction_coefficient", "0.1189"},
                              {"chute.contact_pw.friction_coefficient", "0.097"}});
  return list;
}

v1::Scene scene_of(const Case& c, const std::string& scenes, const std::string& duration) {
  const std::string path = scenes + "/chute_base_" + std::to_string(c.slope) + "deg.txtpb";
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  std::vector<FieldSetting> set = c.set;
  set.push_back({"chute.duration_s", duration});
  set.push_back({"chute.sample_start_s", "1.2"});
  const Result<v1::Scene> scene = load_scene(text.str(), path, set);
  if (!scene) throw std::runtime_error(scene.error().message);
  const Result<ResolvedScene> resolved = resolve(*scene);
  if (!resolved) throw std::runtime_error(resolved.error().message);
  return resolved->scene;
}

using Results = std::map<std::string, ChuteMeans>;

Results run_all(const std::string& scenes, unsigned jobs, const std::string& duration) {
  const std::vector<Case> list = cases();
  std::vector<ChuteMeans> means(list.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t k = next++; k < list.size(); k = next++) {
      means[k] = ChuteMeans::of_run(scene_of(list[k], scenes, duration));
      std::fprintf(stderr, "%s: %.0f s\n", list[k].name.c_str(), means[k].cpu_seconds());
    }
  };
  std::vector<std::thread> helpers;
  for (unsigned k = 1; k < jobs; ++k) helpers.emplace_back(work);
  work();
  for (std::thread& helper : helpers) helper.join();
  Results results;
  for (std::size_t k = 0; k < list.size(); ++k) results[list[k].name] = std::move(means[k]);
  return results;
}

std::string text(const char* format, auto... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

// Largest relative difference of surface velocity at the stations.
double velocity_change(const ChuteMeans& a, const ChuteMeans& b, double from_x = 0.2) {
  double largest = 0;
  for (const double x : kStations) {
    if (x < from_x - 1e-9) continue;
    largest = std::max(largest, std::abs(a.surface_velocity(x) / b.surface_velocity(x) - 1));
  }
  return largest;
}

double height_change(const ChuteMeans& a, const ChuteMeans& b, double from_x) {
  double largest = 0;
  for (const double x : kStations) {
    for (const double y : {0.0175, 0.0475, 0.0675}) {
      if (x < from_x - 1e-9) continue;
      largest = std::max(largest, std::abs(a.bed_height(x, y) - b.bed_height(x, y)));
    }
  }
  return largest;
}

// ------------------------------------------------------------------------------------ the tables

void print_matrix(const Results& results) {
  std::printf(
      "## The matrix\n\n"
      "Surface velocity [m/s] over the width at 0.2, 0.4, 0.6, 0.8 m; across the stream at 0.4 m; "
      "bed "
      "height [mm] at 0.4 m, y = 17.5 / 47.5 / 67.5 mm.\n\n"
      "| case | grains | +- | exit speed | u 0.2 | u 0.4 | u 0.6 | u 0.8 | v 0.4 | height | ledger "
      "|\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const Case& c : cases()) {
    const ChuteMeans& m = results.at(c.name);
    const Mean count = m.value("particle_count"), exit = m.value("exit_speed_m_per_s");
    std::printf(
        "| %s | %.0f | %.0f | %.3f +- %.3f | %.3f | %.3f | %.3f | %.3f | %+.3f |"
        " %.1f / %.1f / %.1f | %.0e |\n",
        c.name.c_str(), count.value, count.error, exit.value, exit.error, m.surface_velocity(0.2),
        m.surface_velocity(0.4), m.surface_velocity(0.6), m.surface_velocity(0.8),
        m.spanwise_velocity(0.4), 1e3 * m.bed_height(0.4, 0.0175), 1e3 * m.bed_height(0.4, 0.0475),
        1e3 * m.bed_height(0.4, 0.0675), m.ledger_remainder());
  }
}

void row(const std::string& claim, const std::string& paper, const std::string& ours,
         const std::string& basis, bool holds) {
  std::printf("| %s | %s | %s | %s | %s |\n", claim.c_str(), paper.c_str(), ours.c_str(),
              basis.c_str(), holds ? "agrees" : "**differs**");
}

void report(const std::string& claim, const std::string& paper, const std::string& ours,
            const std::string& basis) {
  std::printf("| %s | %s | %s | %s | reported |\n", claim.c_str(), paper.c_str(), ours.c_str(),
              basis.c_str());
}

void score_counts(const Results& results) {
  for (const auto& [slope, paper] : {std::pair{30, 31000.0}, std::pair{40, 26000.0}}) {
    double low = 1e9, high = 0;
    for (const int rpm : {0, 4, 8, 16}) {
      const double n = results.at(matrix_name(slope, rpm)).value("particle_count").value;
      low = std::min(low, n), high = std::max(high, n);
    }
    row(text("grains in steady state, %d deg", slope), text("~%.0f", paper),
        text("%.0f .. %.0f (0-16 rpm)", low, high), "range of rotation +- 3 %",
        paper > 0.97 * low && paper < 1.03 * high);
  }
}

void score_contact_data(const Results& results) {
  const ChuteMeans& base = results.at(matrix_name(30, 0));
  const double et = std::max(velocity_change(results.at("e_t 0.1"), base),
                             velocity_change(results.at("e_t 0.9"), base));
  row("e_t 0.1 .. 0.9", "nearly indistinguishable", text("%.2f %% in surface velocity", 100 * et),
      "1 % and the noise of one run, 0.5 %", et < 0.015);
  const double en = std::max(velocity_change(results.at("e_n 0.3"), base),
                             velocity_change(results.at("e_n 0.99"), base));
  row("e_n 0.3 .. 0.99", "very weak", text("%.2f %% in surface velocity", 100 * en), "3 %",
      en < 0.03);
  const double slow = results.at("mu 0.35").surface_velocity(0.8);
  const double middle = base.surface_velocity(0.8);
  const double fast = results.at("mu 0.12").surface_velocity(0.8);
  row("mu of the walls 0.12, 0.22, 0.35", "strong, monotone decrease",
      text("%.2f > %.2f > %.2f m/s at 0.8 m", fast, middle, slow), "order, and > 3 % each",
      fast > 1.03 * middle && middle > 1.03 * slow);
  const double slight = velocity_change(results.at("mu_r 0.05"), base);
  const double near_mu = velocity_change(results.at("mu_r 0.2"), base);
  row("mu_r 0.05, 0.2", "slight, except near mu",
      text("%.2f %%, %.2f %% in surface velocity", 100 * slight, 100 * near_mu),
      "order, the first < 3 %", slight < 0.03 && near_mu > slight);
}

void score_inlet(const Results& results) {
  const ChuteMeans& base = results.at(matrix_name(30, 0));
  for (const char* sluice : {"sluice 0.03", "sluice 0.02"}) {
    const double v = velocity_change(results.at(sluice), base, 0.2);
    const double h = height_change(results.at(sluice), base, 0.2);
    row(std::string("inlet memory beyond 0.2 m, ") + sluice + " m against 0.045 m",
        "none (h > 3 cm)", text("%.2f %% in velocity, %.2f mm in height", 100 * v, 1e3 * h),
        "2 %, 1.5 mm", v < 0.02 && h < 0.0015);
  }
  const ChuteMeans& turning = results.at(matrix_name(30, 16));
  const double v = velocity_change(results.at("sluice 0.03, 16 rpm"), turning, 0.4);
  const double h = height_change(results.at("sluice 0.03, 16 rpm"), turning, 0.4);
  row("the same beyond 0.4 m at 16 rpm", "none",
      text("%.2f %% in velocity, %.2f mm in height", 100 * v, 1e3 * h), "2 %, 1.5 mm",
      v < 0.02 && h < 0.0015);
}

void score_structure(const Results& results) {
  const ChuteMeans& base = results.at(matrix_name(30, 0));
  double least = 1, bottom = 0;
  for (const double x : kStations) {
    double base_speed = 0, top_speed = 0, solid = 0;
    for (const ChuteMeans::DepthBin& bin : base.depth_profile()) {
      if (std::abs(bin.x - x) > 1e-6) continue;
      if (bin.height < 0.003 && base_speed == 0) base_speed = bin.streamwise;
      if (bin.solid_fraction > 0.1) top_speed = bin.streamwise;
      if (bin.height < 0.006) solid += bin.solid_fraction / 4;
    }
    least = std::min(least, base_speed / top_speed);
    if (x == 0.2) bottom = solid;
  }
  row("plug flow: slip at the base dominates", "small shear", text("v base / v top >= %.2f", least),
      "> 0.8 at four stations", least > 0.8);
  row("solid fraction at the bottom", "near random close",
      text("%.2f (lowest 6 mm, x = 0.2 m)", bottom), "0.55 .. 0.64",
      bottom > 0.55 && bottom < 0.64);
}

void score_rotation(const Results& results) {
  const ChuteMeans& still = results.at(matrix_name(30, 0));
  const ChuteMeans& turning = results.at(matrix_name(30, 16));
  const auto half = [](const ChuteMeans& m, bool high) {
    return m.surface_velocity(0.6, high ? 0.04 : 0, high ? 0.08 : 0.04);
  };
  row("16 rpm: the half it is pushed to slower, the other slightly faster than at 0 rpm",
      "right slower, left faster",
      text("y > 40 mm: %.3f -> %.3f, y < 40 mm: %.3f -> %.3f m/s at 0.6 m", half(still, true),
           half(turning, true), half(still, false), half(turning, false)),
      "sign", half(turning, true) < half(still, true) && half(turning, false) > half(still, false));
  double rises = 0, peak_x = 0;
  for (const double x : {0.099, 0.201, 0.303, 0.399, 0.501, 0.603}) {
    const double v = std::abs(turning.spanwise_velocity(x));
    if (v > rises) rises = v, peak_x = x;
  }
  const double end = std::abs(turning.spanwise_velocity(0.603));
  row("speed across rises, then falls downstream (16 rpm)", "x 0 .. 0.6 m",
      text("largest %.3f m/s at x = %.2f m, %.3f at 0.60 m", rises, peak_x, end), "shape",
      peak_x < 0.6 && end < rises);
  const auto across = [&](int slope, int rpm) {
    return std::abs(results.at(matrix_name(slope, rpm)).spanwise_velocity(0.201));
  };
  row("it grows with rotation and angle", "grows",
      text("30 deg: %.3f, %.3f, %.3f; 40 deg: %.3f, %.3f, %.3f m/s at 4, 8, 16 rpm, x = 0.2 m",
           across(30, 4), across(30, 8), across(30, 16), across(40, 4), across(40, 8),
           across(40, 16)),
      "order",
      across(30, 4) < across(30, 8) && across(30, 8) < across(30, 16) &&
          across(40, 4) < across(40, 8) && across(40, 8) < across(40, 16));
  const double near = velocity_change(results.at("axis 0.10"), turning);
  const double far = velocity_change(results.at("axis 0.25"), turning);
  report("axis 0.10 and 0.25 m instead of 0.165 m from the inlet", "origin not printed",
         text("%.1f %%, %.1f %% in surface velocity", 100 * near, 100 * far),
         "sensitivity at 16 rpm");
  report("where the bed is highest at 16 rpm", "right, in the experiment",
         text("%.1f / %.1f / %.1f mm at y = 17.5 / 47.5 / 67.5 mm, x = 0.4 m",
              1e3 * turning.bed_height(0.4, 0.0175), 1e3 * turning.bed_height(0.4, 0.0475),
              1e3 * turning.bed_height(0.4, 0.0675)),
         "Coriolis pushes to y = 80 mm");
}

void score_rest(const Results& results) {
  const ChuteMeans& base = results.at(matrix_name(30, 0));
  const ChuteMeans& measured = results.at("measured friction");
  report("measured friction 0.1189 / 0.097, k_n 1000 N/m", "needs stiffer grains",
         text("%.2f against %.2f m/s at 0.8 m", measured.surface_velocity(0.8),
              base.surface_velocity(0.8)),
         "plug slip gives 2.57 m/s at 0.8 m");
  report("cost of a particle-step", "3.4e5 per second on one core (2009)",
         text("%.2e per second (dt 1e-5 s)", base.particle_steps() / base.cpu_seconds()),
         "CPU time, measurements included");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: chute_claims SCENES_DIR [--jobs N] [--duration S]\n";
    return 64;
  }
  unsigned jobs = 1;
  std::string duration = "2.4";
  for (int k = 2; k + 1 < argc; k += 2) {
    if (std::string(argv[k]) == "--jobs") jobs = static_cast<unsigned>(std::atoi(argv[k + 1]));
    if (std::string(argv[k]) == "--duration") duration = argv[k + 1];
  }
  const Results results = run_all(argv[1], jobs, duration);
  std::printf(
      "# The chute paper's claims, scored\n\nMade by `chute_claims tests/scenes`, gas off, "
      "dt 1e-5 s, means from 1.2 s to %s s.\n\n",
      duration.c_str());
  print_matrix(results);
  std::printf(
      "\n## The claims\n\n| claim | paper | ours | verdict rests on | verdict |\n"
      "| --- | --- | --- | --- | --- |\n");
  score_counts(results);
  score_contact_data(results);
  score_inlet(results);
  score_structure(results);
  score_rotation(results);
  score_rest(results);
}
