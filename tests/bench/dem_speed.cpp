// Times the DEM engine on a steady state: ns per particle and step, minimum and median of blocks.
// CPU time for one thread, wall time for more.
//
//   --state FILE.csv  rows x,y,z,u,v,w in m and m/s after a header line: a chute of 30 deg with the
//                     contact data of the chute paper's base case, no feed. Without it a dense bed:
//                     grains settled in a closed chute, tilted to 10 deg
//   --closed          the state of a file is such a bed
//   --copies N        the state N times side by side across the chute; < 0: only its first 1/N
//   --dt S --rpm R --threads N --path NAME --warm STEPS --steps STEPS --blocks N
//   --save FILE.csv, --export FILE.data   the state after warming up, for --state and for LAMMPS
//   --quiet           one line; --samples: nothing but the ns of every block
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>

#include "worker/dem/block_engine.h"
#include "worker/dem/plain_engine.h"

namespace {

using namespace granary;
using core::Vec3;

struct Options {
  std::map<std::string, std::string> values;
  bool has(const std::string& name) const { return values.count(name) != 0; }
  std::string text(const std::string& name, const std::string& otherwise) const {
    const auto it = values.find(name);
    return it == values.end() ? otherwise : it->second;
  }
  double number(const std::string& name, double otherwise) const {
    const auto it = values.find(name);
    return it == values.end() ? otherwise : std::stod(it->second);
  }
};

Options parse(int argc, char** argv) {
  Options options;
  for (int k = 1; k < argc; ++k) {
    const std::string name = argv[k];
    if (name == "--quiet" || name == "--closed" || name == "--samples")
      options.values[name] = "1";
    else if (k + 1 < argc)
      options.values[name] = argv[++k];
  }
  return options;
}

std::vector<dem::Grain> read_state(const std::string& file) {
  std::ifstream in(file);
  if (!in) std::cerr << "cannot read " << file << "\n", std::exit(2);
  std::vector<dem::Grain> grains;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    dem::Grain g;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf", &g.position.x, &g.position.y,
                    &g.position.z, &g.velocity.x, &g.velocity.y, &g.velocity.z) == 6 &&
        g.position.x >= 0) {
      grains.push_back(g);
    }
  }
  return grains;
}

constexpr double kWidth = 0.08;

dem::EngineSetup chute_setup(double slope_degrees, double dt, double rpm, double width) {
  const double slope = slope_degrees * std::numbers::pi / 180;
  const Vec3 down{std::sin(slope), 0, -std::cos(slope)};
  dem::EngineSetup setup;
  setup.classes = {{0.0015, 2550}};
  setup.grain_grain = {1000, 0.97, 0.33, 0.12, 0, 0};
  setup.grain_wall = {1000, 0.95, 0.33, 0.22, 0, 0};
  setup.walls = {{{0, 0, 0}, {0, 0, 1}}, {{0, 0, 0}, {0, 1, 0}}, {{0, width, 0}, {0, -1, 0}}};
  setup.motion.gravity = down * 9.81;
  setup.motion.omega = down * (rpm * 2 * std::numbers::pi / 60);
  setup.motion.axis_point = {0.165, 0.5 * width, 0};
  setup.time_step = dt;
  return setup;
}

std::vector<dem::Grain> scaled(const std::vector<dem::Grain>& state, int copies) {
  std::vector<dem::Grain> grains;
  if (copies < 0) {
    const double end = 0.3 + 0.9 / -copies;
    for (const dem::Grain& g : state) {
      if (g.position.x >= 0.3 && g.position.x < end) grains.push_back(g);
    }
    return grains;
  }
  for (int copy = 0; copy < copies; ++copy) {
    for (dem::Grain g : state) {
      g.position.y += copy * kWidth;
      grains.push_back(g);
    }
  }
  return grains;
}

// Loose grains on a grid above the floor of a closed chute, left to settle.
std::vector<dem::Grain> settled_bed(dem::EngineSetup setup, std::size_t count) {
  setup.motion.omega = {};
  setup.motion.gravity = {0, 0, -9.81};
  setup.grain_grain.normal_restitution = setup.grain_wall.normal_restitution = 0.3;
  std::vector<dem::Grain> grains(count);
  const double spacing = 1.06 * 0.003;
  const auto across = static_cast<std::size_t>(kWidth / spacing);
  const auto along = static_cast<std::size_t>(0.9 / spacing);
  for (std::size_t k = 0; k < count; ++k) {
    const auto wiggle = [&](std::size_t s) {
      return 2e-5 * static_cast<double>((k * 7919 + s * 104729) % 11);
    };
    grains[k].position = {spacing * (0.5 + static_cast<double>(k / across % along)) + wiggle(1),
                          spacing * (0.5 + static_cast<double>(k % across)) + wiggle(2),
                          spacing * (0.5 + static_cast<double>(k / (across * along)))};
  }
  dem::BlockEngine engine(setup);
  engine.insert(grains);
  engine.advance(static_cast<std::uint64_t>(0.35 / setup.time_step));
  const dem::GrainTable table = engine.grains();
  for (std::size_t k = 0; k < count; ++k) grains[k].position = table.position[k];
  return grains;
}

void save_state(const dem::Engine& engine, const std::string& file) {
  const dem::GrainTable t = engine.grains();
  std::ofstream out(file);
  out.precision(17);
  out << "x_m,y_m,z_m,u_m_s,v_m_s,w_m_s\n";
  for (std::size_t k = 0; k < t.size(); ++k) {
    out << t.position[k].x << ',' << t.position[k].y << ',' << t.position[k].z << ','
        << t.velocity[k].x << ',' << t.velocity[k].y << ',' << t.velocity[k].z << '\n';
  }
}

void export_lammps(const dem::Engine& engine, const std::string& file, double width) {
  const dem::GrainTable t = engine.grains();
  std::ofstream out(file);
  out.precision(17);
  out << "Exported grains, positions m, velocities m/s\n\n"
      << t.size() << " atoms\n1 atom types\n\n"
      << "-0.01 2.0 xlo xhi\n-0.002 " << width + 0.002
      << " ylo yhi\n-0.002 0.2 zlo zhi\n\nAtoms\n\n";
  for (std::size_t k = 0; k < t.size(); ++k) {
    out << k + 1 << " 1 " << 2 * t.radius[k] << " 2550 " << t.position[k].x << ' '
        << t.position[k].y << ' ' << t.position[k].z << '\n';
  }
  out << "\nVelocities\n\n";
  for (std::size_t k = 0; k < t.size(); ++k) {
    out << k + 1 << ' ' << t.velocity[k].x << ' ' << t.velocity[k].y << ' ' << t.velocity[k].z
        << ' ' << t.spin[k].x << ' ' << t.spin[k].y << ' ' << t.spin[k].z << '\n';
  }
}

const dem::Kernels& kernels_named(const std::string& name) {
  for (const dem::Kernels* k : dem::available_kernels()) {
    if (k->name == name) return *k;
  }
  return dem::kernels();
}

double seconds(bool cpu) {
  if (cpu) {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void report(const dem::BlockEngine& engine, double per_step) {
  std::printf(
      "contacts/grain %.3f  inner slots/grain %.3f  outer pairs/grain %.2f  late contacts %lu  "
      "steps per order %.0f  overlap/R %.3f  ledger remainder %.2e\n",
      double(engine.contact_count()) / engine.grain_count(),
      double(engine.inner_slots()) / engine.grain_count(),
      double(engine.outer_pairs()) / engine.grain_count(), engine.late_contacts(),
      double(engine.step()) / engine.order_rebuilds(), engine.largest_overlap_ratio(),
      engine.ledger().remainder_ratio());
  double total = 0;
  for (const auto& phase : engine.profile()) total += phase.seconds;
  for (const auto& phase : engine.profile()) {
    std::printf("  %-16s %5.1f %%  %5.2f ns\n", phase.phase.c_str(), 100 * phase.seconds / total,
                per_step * phase.seconds / total);
  }
}

dem::EngineSetup setup_of(const Options& options) {
  const int copies = static_cast<int>(options.number("--copies", 1));
  const bool is_closed = !options.has("--state") || options.has("--closed");
  dem::EngineSetup setup = chute_setup(is_closed ? 10 : 30, options.number("--dt", 1e-5),
                                       options.number("--rpm", 0), kWidth * std::max(1, copies));
  if (is_closed) {
    setup.walls.push_back({{0.9, 0, 0}, {-1, 0, 0}});
    setup.walls.push_back({{0, 0, 0}, {1, 0, 0}});
  }
  setup.threads = static_cast<unsigned>(options.number("--threads", 1));
  return setup;
}

std::vector<dem::Grain> grains_of(const Options& options, const dem::EngineSetup& setup) {
  const std::string file = options.text("--state", "");
  return scaled(file.empty() ? settled_bed(setup, 31000) : read_state(file),
                static_cast<int>(options.number("--copies", 1)));
}

// ns per particle and step of every block.
std::vector<double> timed_blocks(dem::BlockEngine& engine, int blocks, std::uint64_t steps) {
  const bool is_alone = engine.setup().threads == 1;
  std::vector<double> times;
  for (int block = 0; block < blocks; ++block) {
    const std::uint64_t before = engine.particle_steps();
    const double start = seconds(is_alone);
    engine.advance(steps);
    times.push_back(1e9 * (seconds(is_alone) - start) /
                    static_cast<double>(engine.particle_steps() - before));
  }
  return times;
}

void print(const Options& options, const dem::BlockEngine& engine, std::vector<double> times) {
  if (engine.trouble()) std::printf("trouble: %s\n", engine.trouble()->reason.c_str());
  if (options.has("--samples")) {
    for (const double time : times) std::printf("%.2f\n", time);
    return;
  }
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  const double median = times[times.size() / 2];
  std::printf("%s %zu grains dt %g threads %u: ns/particle-step min %.2f median %.2f\n",
              kernels_named(options.text("--path", "")).name, engine.grain_count(),
              engine.setup().time_step, engine.setup().threads, times.front(), median);
  if (!options.has("--quiet")) report(engine, median);
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = parse(argc, argv);
  const dem::EngineSetup setup = setup_of(options);
  dem::BlockEngine engine(setup, kernels_named(options.text("--path", "")));
  engine.insert(grains_of(options, setup));
  engine.advance(static_cast<std::uint64_t>(options.number("--warm", 200)));
  if (options.has("--save")) save_state(engine, options.text("--save", ""));
  if (options.has("--export")) {
    export_lammps(engine, options.text("--export", ""),
                  kWidth * std::max(1, static_cast<int>(options.number("--copies", 1))));
  }
  print(options, engine,
        timed_blocks(engine, static_cast<int>(options.number("--blocks", 5)),
                     static_cast<std::uint64_t>(options.number("--steps", 500))));
}
