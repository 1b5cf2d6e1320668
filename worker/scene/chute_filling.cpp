#include "worker/scene/chute_filling.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "worker/core/random.h"
#include "worker/dem/surface_mesh.h"

namespace granary::scene {
namespace {

using core::Vec3;

constexpr double kSpacing = 1.06;  // of the grid, in largest diameters
constexpr double kJitter = 0.02;   // so that the bed does not crystallise, in largest diameters
constexpr double kSettlingRestitution = 0.3;
constexpr double kSettlingTime = 0.15;  // s after the highest grain could have landed

double largest_radius(const ChutePlan& plan) {
  double largest = 0;
  for (const dem::GrainClass& c : plan.engine.classes) largest = std::max(largest, c.radius);
  return largest;
}

struct Grid {
  double spacing;
  double begin;  // x of its upstream end
  std::size_t along, across;
  double height_of(std::size_t count) const {
    return spacing * std::ceil(static_cast<double>(count) / static_cast<double>(along * across));
  }
};

Grid grid_of(const ChutePlan& plan) {
  const double spacing = kSpacing * 2 * largest_radius(plan);
  const auto fit = [&](double length) {
    return static_cast<std::size_t>(std::max(1.0, std::floor(length / spacing)));
  };
  const double length = plan.hopper ? plan.hopper->length : plan.geometry.length;
  return {spacing, plan.hopper ? -length : 0, fit(length), fit(plan.geometry.width)};
}

std::uint8_t draw_class(const ChutePlan& plan, std::uint64_t grain) {
  double total = 0;
  for (std::size_t k = 0; k < plan.engine.classes.size(); ++k) {
    total += plan.mass_fractions[k] / plan.engine.classes[k].mass();
  }
  double draw = total * core::random_uniform(plan.seed, 11, grain);
  for (std::size_t k = 0; k + 1 < plan.engine.classes.size(); ++k) {
    draw -= plan.mass_fractions[k] / plan.engine.classes[k].mass();
    if (draw < 0) return static_cast<std::uint8_t>(k);
  }
  return static_cast<std::uint8_t>(plan.engine.classes.size() - 1);
}

// Sites that the mesh runs through stay empty.
std::vector<dem::Grain> loose_grid(const ChutePlan& plan, const dem::SurfaceMesh& mesh) {
  const Grid grid = grid_of(plan);
  std::vector<dem::Grain> grains;
  std::vector<std::uint32_t> in_the_way;
  for (std::size_t site = 0; grains.size() < plan.initial_count; ++site) {
    const std::size_t k = grains.size();
    const auto noise = [&](std::uint64_t axis) {
      return kJitter * 2 * largest_radius(plan) *
             (2 * core::random_uniform(plan.seed, 12, 3 * k + axis) - 1);
    };
    const auto centre = [&](std::size_t cell) {
      return (static_cast<double>(cell) + 0.5) * grid.spacing;
    };
    const std::size_t level = site / (grid.along * grid.across);
    const std::size_t in_level = site % (grid.along * grid.across);
    dem::Grain grain;
    grain.position = {grid.begin + centre(in_level / grid.across) + noise(0),
                      centre(in_level % grid.across) + noise(1), centre(level) + noise(2)};
    in_the_way.clear();
    mesh.add_near(grain.position, largest_radius(plan), in_the_way);
    if (!in_the_way.empty()) continue;
    grain.grain_class = draw_class(plan, k);
    grains.push_back(grain);
  }
  return grains;
}

}  // namespace

std::unique_ptr<dem::Engine> make_filling(const ChutePlan& plan) {
  dem::EngineSetup setup = plan.engine;
  setup.motion = {};
  setup.outlet_x = std::numeric_limits<double>::infinity();
  setup.grain_grain.normal_restitution = kSettlingRestitution;
  setup.grain_wall.normal_restitution = kSettlingRestitution;
  if (plan.hopper) {
    setup.motion.gravity = plan.engine.motion.gravity;
    setup.walls.push_back(plan.hopper->shut);
    setup.triangles.resize(setup.triangles.size() - plan.hopper->gate.size());
  } else {
    setup.motion.gravity = {0, 0, -norm(plan.engine.motion.gravity)};
    setup.walls.push_back({{0, 0, 0}, {1, 0, 0}});
    setup.walls.push_back({{plan.geometry.length, 0, 0}, {-1, 0, 0}});
  }
  std::unique_ptr<dem::Engine> engine = dem::make_engine(setup);
  engine->insert(loose_grid(plan, dem::SurfaceMesh(setup.triangles)));
  return engine;
}

double filling_duration(const ChutePlan& plan) {
  const double gravity = norm(plan.engine.motion.gravity);
  const double fall = grid_of(plan).height_of(plan.initial_count);
  return kSettlingTime + (gravity > 0 ? std::sqrt(2 * fall / gravity) : 0);
}

core::State filling_state(const dem::Engine& settled) {
  const dem::GrainTable table = settled.grains();
  std::vector<std::size_t> order(table.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t l, std::size_t r) { return table.id[l] < table.id[r]; });
  std::vector<double> position;
  std::vector<std::uint8_t> grain_class;
  for (const std::size_t k : order) {
    const Vec3& p = table.position[k];
    position.insert(position.end(), {p.x, p.y, p.z});
    grain_class.push_back(table.grain_class[k]);
  }
  core::State state;
  state.put("filling.position_m", "m", position, 3);
  state.put("filling.class", "1", grain_class);
  return state;
}

std::vector<dem::Grain> grains_of_filling(const core::State& filling, const ChutePlan& plan) {
  const auto position = filling.get<double>("filling.position_m");
  const auto grain_class = filling.get<std::uint8_t>("filling.class");
  if (position.size() != 3 * grain_class.size() || grain_class.size() != plan.initial_count) {
    throw std::runtime_error("state: filling of another scene");
  }
  std::vector<dem::Grain> grains(grain_class.size());
  for (std::size_t k = 0; k < grains.size(); ++k) {
    grains[k].position = {position[3 * k], position[3 * k + 1], position[3 * k + 2]};
    grains[k].grain_class = grain_class[k];
  }
  return grains;
}

}  // namespace granary::scene
