#include "worker/dem/law_tables.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "worker/dem/pair_coefficients.h"

namespace granary::dem {
namespace {

using core::Mat3;
using core::Vec3;

// Wider than what a square and a root in float can lose.
constexpr double kNearly = 1 + 1e-6;

// `b` is null for a wall.
void fill(LawTables& table, std::size_t kind, const ContactCoefficients& law, const GrainClass& a,
          const GrainClass* b, double time_step) {
  const auto set = [kind](LawTables::Row& row, double value) {
    row[kind] = static_cast<float>(value);
  };
  const double radius_b = b != nullptr ? b->radius : 0;
  const double response_b = b != nullptr ? b->radius / b->inertia() : 0;
  const double reach = a.radius + radius_b;
  set(table.reach, reach);
  set(table.near_square, reach * reach * kNearly);
  set(table.inverse_radius, 1 / (b != nullptr ? std::min(a.radius, radius_b) : a.radius));
  set(table.normal_stiffness, law.normal_stiffness);
  set(table.normal_damping, law.normal_damping);
  set(table.tangential_stiffness, law.tangential_stiffness);
  set(table.tangential_damping, law.tangential_damping);
  set(table.friction, law.friction);
  set(table.inverse_tangential_stiffness, 1 / law.tangential_stiffness);
  set(table.cohesion, law.cohesion);
  set(table.rolling_arm, law.rolling_arm);
  set(table.stopping, law.reduced_inertia / time_step);
  set(table.inverse_radius_a, 1 / a.radius);
  set(table.inverse_radius_b, b != nullptr ? 1 / radius_b : 0);
  set(table.spin_response, (a.radius / a.inertia() - response_b) * time_step);
}

Mat3 cross_matrix(const Vec3& w) {
  return {{Vec3{0, -w.z, w.y}, Vec3{w.z, 0, -w.x}, Vec3{-w.y, w.x, 0}}};
}

Mat3 scaled(const Mat3& m, double factor) {
  return {{m.rows[0] * factor, m.rows[1] * factor, m.rows[2] * factor}};
}

void put_cyclic(double (&out)[3][3], const Mat3& m) {
  for (std::size_t i = 0; i < 3; ++i) {
    const double row[3] = {m.rows[i].x, m.rows[i].y, m.rows[i].z};
    for (std::size_t j = 0; j < 3; ++j) out[i][j] = row[(i + j) % 3];
  }
}

}  // namespace

Laws law_tables(const EngineSetup& setup) {
  const std::size_t classes = setup.classes.size();
  if (classes > kMaxClasses) {
    throw std::invalid_argument("particles: more than " + std::to_string(kMaxClasses) +
                                " classes in one mixture are not available");
  }
  const PairCoefficients coefficients = pair_coefficients(setup);
  Laws laws = {};
  laws.pairs.kinds = classes * classes;
  laws.walls.kinds = classes;
  for (std::size_t a = 0; a < classes; ++a) {
    for (std::size_t b = 0; b < classes; ++b) {
      const std::size_t kind = a * classes + b;
      fill(laws.pairs, kind, coefficients.grain_grain[kind], setup.classes[a], &setup.classes[b],
           setup.time_step);
    }
    fill(laws.walls, a, coefficients.grain_wall[a], setup.classes[a], nullptr, setup.time_step);
  }
  return laws;
}

WallTables wall_tables(const std::vector<Plane>& walls) {
  if (walls.size() > kMaxWalls) {
    throw std::invalid_argument("walls: more than " + std::to_string(kMaxWalls) +
                                " planes are not available");
  }
  WallTables table = {};
  table.count = walls.size();
  for (std::size_t w = 0; w < walls.size(); ++w) {
    table.normal_x[w] = static_cast<float>(walls[w].normal.x);
    table.normal_y[w] = static_cast<float>(walls[w].normal.y);
    table.normal_z[w] = static_cast<float>(walls[w].normal.z);
  }
  return table;
}

// With X = [Omega]x and S = (I + dt X)^-1 the kick is
//   v' = S (v + (F/m + g - X X (x - p) - X v) dt) = v + (S F/m - S X X x - 2 S X v + S (g + X X p))
//   dt,
// and likewise for spins with half the angle.
BodyCoefficients body_coefficients(const EngineSetup& setup) {
  BodyCoefficients body;
  body.time_step = setup.time_step;
  body.turning_factor = setup.effects.spin ? 2.5 : 0;
  const Vec3 omega = setup.motion.frame == FrameKind::corotating ? setup.motion.omega : Vec3{};
  const Mat3 x = cross_matrix(omega);
  const Mat3 solve = core::inverse_of_one_plus_cross(omega * setup.time_step);
  const Mat3 spin_solve = core::inverse_of_one_plus_cross(omega * (0.5 * setup.time_step));
  const Vec3 constant = solve * (setup.motion.gravity + (x * x) * setup.motion.axis_point);
  body.constant[0] = constant.x;
  body.constant[1] = constant.y;
  body.constant[2] = constant.z;
  put_cyclic(body.per_position, scaled(solve * (x * x), -1));
  put_cyclic(body.per_velocity, scaled(solve * x, -2));
  put_cyclic(body.per_force, solve);
  put_cyclic(body.per_turning, spin_solve);
  put_cyclic(body.per_surface, scaled(spin_solve * x, setup.effects.spin ? -1 : 0));
  return body;
}

}  // namespace granary::dem
