#include "tests/bench/explicit_disks.h"

#include <cmath>
#include <numbers>

#include "worker/dda/impulse_solver.h"
#include "worker/dda/kernel_one_solve.h"
#include "worker/dda/narrow_phase.h"

namespace granary::dda {
namespace {

// Impulses of one explicit step, gathered per disk: momentum and surface momentum.
struct alignas(32) Push {
  double x = 0, y = 0, surface = 0, unused = 0;
};

struct ExplicitTerms {
  double step, stiffness, damping_n, damping_t, friction, elapsed;
};

[[gnu::always_inline]] inline void put_pushes(Push* pushes, const std::int32_t* index,
                                              const Records& v) {
  put_back(reinterpret_cast<DiskMotion*>(pushes), index, v);
}

// Forces of one list: spring and dashpot along the normal, never pulling; tangential spring and
// dashpot within Coulomb's limit. impulse_n and impulse_t hold the forces.
template <bool kWall>
void push_contacts(const ContactArrays& contact, std::size_t count, const ExplicitTerms& terms,
                   const DiskShift* shift, const DiskMotion* motion, Push* pushes) {
  for (std::size_t g = 0; g < count; g += kGroupSize) {
    const Lanes nx = load(contact.normal_x + g), ny = load(contact.normal_y + g);
    const Records moved1 = fetch(shift, contact.first + g);
    const Records moved2 = kWall ? Records{} : fetch(shift, contact.second + g);
    const Records first = fetch(motion, contact.first + g);
    const Records second = kWall ? Records{} : fetch(motion, contact.second + g);
    const Lanes dx = moved2.a - moved1.a, dy = moved2.b - moved1.b;
    Lanes gap = load(contact.gap_linear + g) + dx * nx + dy * ny, across = dy * nx - dx * ny;
    Lanes un = (second.a - first.a) * nx + (second.b - first.b) * ny;
    Lanes ut = surface_speed(first, second, nx, ny);
    if constexpr (kWall) {
      gap += load(contact.drift_n + g) * terms.elapsed;
      un += load(contact.drift_n + g);
      ut += load(contact.drift_t + g);
    } else {
      const Lanes side = load(contact.offset_t + g) + across;
      gap += load(contact.curvature + g) * side * side;
    }
    const Lanes force =
        either(gap < 0.0, larger(-terms.stiffness * gap - terms.damping_n * un, Lanes{}), Lanes{});
    const Lanes limit = terms.friction * force;
    const Lanes spring = load(contact.impulse_t + g) - terms.stiffness * terms.step * ut;
    const Lanes kept = within(spring, limit);
    const Lanes force_t = within(spring - terms.damping_t * ut, limit);
    store(contact.impulse_n + g, force);
    store(contact.impulse_t + g, kept);
    const Lanes px = terms.step * (force * nx - force_t * ny);
    const Lanes py = terms.step * (force * ny + force_t * nx);
    const Lanes turn = terms.step * force_t;
    Records push1 = fetch(pushes, contact.first + g);
    push1.a -= px, push1.b -= py, push1.c -= turn;
    put_pushes(pushes, contact.first + g, push1);
    if constexpr (!kWall) {
      Records push2 = fetch(pushes, contact.second + g);
      push2.a += px, push2.b += py, push2.c -= turn;
      put_pushes(pushes, contact.second + g, push2);
    }
  }
}

void move_disks(System& system, double step, std::vector<Push>& pushes) {
  const double fall = system.gravity * step, spin = 2;
  for (const std::uint32_t k : system.touched_index) {
    DiskMotion& v = system.disks.motion[k];
    DiskShift& moved = system.shift[k];
    v.vx += v.inverse_mass * pushes[k].x;
    v.vy += v.inverse_mass * pushes[k].y - fall;
    v.surface_speed += spin * v.inverse_mass * pushes[k].surface;
    moved.x += step * v.vx;
    moved.y += step * v.vy;
    moved.surface += step * v.surface_speed;
    pushes[k] = {};
  }
}

void finish(System& system) {
  const double dt = system.time_step;
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    DiskPose& pose = system.disks.pose[k];
    DiskMotion& v = system.disks.motion[k];
    if (system.touched[k]) {
      pose.x += system.shift[k].x;
      pose.y += system.shift[k].y;
      continue;
    }
    pose.x += dt * v.vx;
    pose.y += dt * (v.vy - 0.5 * system.gravity * dt);
    v.vy -= system.gravity * dt;
  }
  system.time += dt;
}

// The warm start of the implicit solver is h times the force: back to forces.
void read_forces(ActiveContacts& contacts, double small_step) {
  for (std::size_t k = 0; k < contacts.size; ++k) contacts.impulse_t[k] /= small_step;
}

void keep(const ActiveContacts& contacts, CandidateList& list) {
  std::fill(list.normal_force.begin(), list.normal_force.end(), 0.0);
  std::fill(list.tangential_force.begin(), list.tangential_force.end(), 0.0);
  for (std::size_t k = 0; k < contacts.size; ++k) {
    if (contacts.slot[k] < 0) continue;
    list.normal_force[static_cast<std::size_t>(contacts.slot[k])] = contacts.impulse_n[k];
    list.tangential_force[static_cast<std::size_t>(contacts.slot[k])] = contacts.impulse_t[k];
  }
}

}  // namespace
}  // namespace granary::dda

namespace granary::bench {

using namespace granary::dda;

double contact_time_step(const System& system, double parts) {
  return std::numbers::pi * std::sqrt(system.mean_mass / 2 / system.contact.stiffness) / parts;
}

void explicit_step(System& system, double longest) {
  system.lists.refresh(
      system.disks, system.walls,
      {system.bucket_pose(system.time), system.bucket_pose(system.time + system.time_step),
       system.time_step, system.solver.margin_ratio});
  select_contacts(system);
  const std::size_t count = system.disks.count();
  system.shift.assign(count + 1, {});
  system.touched_index.clear();
  for (std::size_t k = 0; k < count; ++k)
    if (system.touched[k]) system.touched_index.push_back(static_cast<std::uint32_t>(k));
  const ContactTerms of_pairs = pair_terms(system), of_walls = wall_terms(system);
  read_forces(system.pair_contacts, of_pairs.small_step);
  read_forces(system.wall_contacts, of_walls.small_step);
  const ContactArrays pairs = arrays_of(system.pair_contacts);
  const ContactArrays walls = arrays_of(system.wall_contacts);
  const auto steps = static_cast<std::size_t>(std::ceil(system.time_step / longest));
  const double h = system.time_step / static_cast<double>(steps);
  static thread_local std::vector<Push> pushes;
  pushes.assign(count + 1, {});
  for (std::size_t s = 0; s < steps; ++s) {
    const double elapsed = h * static_cast<double>(s);
    push_contacts<false>(
        pairs, system.pair_contacts.size,
        {h, of_pairs.stiffness, of_pairs.damping_n, of_pairs.damping_t, of_pairs.friction, elapsed},
        system.shift.data(), system.disks.motion.data(), pushes.data());
    push_contacts<true>(
        walls, system.wall_contacts.size,
        {h, of_walls.stiffness, of_walls.damping_n, of_walls.damping_t, of_walls.friction, elapsed},
        system.shift.data(), system.disks.motion.data(), pushes.data());
    move_disks(system, h, pushes);
  }
  keep(system.pair_contacts, system.lists.pairs);
  keep(system.wall_contacts, system.lists.walls);
  finish(system);
}

}  // namespace granary::bench
