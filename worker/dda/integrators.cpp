#include "worker/dda/integrators.h"

#include "worker/dda/narrow_phase.h"

namespace granary::dda {
namespace {

// `impulse / dt` of every contact as accelerations of its disks. Masses: c M as in `motion`.
void accumulate(const System& system, const ActiveContacts& contacts, double spin_factor,
                std::vector<DiskAcceleration>& acceleration) {
  const double scale = mass_factor(system.solver.integrator) / system.time_step;
  for (std::size_t k = 0; k < contacts.size; ++k) {
    if (contacts.slot[k] < 0) continue;
    const double pn = contacts.impulse_n[k], pt = contacts.impulse_t[k];
    const double px = pn * contacts.normal_x[k] - pt * contacts.normal_y[k];
    const double py = pn * contacts.normal_y[k] + pt * contacts.normal_x[k];
    for (const auto& [disk, sign] :
         {std::pair{contacts.first[k], -1.0}, std::pair{contacts.second[k], 1.0}}) {
      const auto d = static_cast<std::size_t>(disk);
      const double per_mass = scale * system.disks.motion[d].inverse_mass;
      acceleration[d].x += sign * per_mass * px;
      acceleration[d].y += sign * per_mass * py;
      acceleration[d].surface -= per_mass * spin_factor * pt;
    }
  }
}

}  // namespace

double mass_factor(Integrator integrator) {
  switch (integrator) {
    case Integrator::newmark_dda:
      return 2;
    case Integrator::newmark_trapezoid:
      return 4;
    default:
      return 1;
  }
}

double start_force_share(Integrator integrator) {
  return integrator == Integrator::newmark_trapezoid ? 0.5 : 0;
}

void begin_integration(System& system) {
  system.motion_before = system.disks.motion;
  const double factor = mass_factor(system.solver.integrator);
  if (factor == 1) return;
  for (DiskMotion& v : system.disks.motion) v.inverse_mass /= factor;
}

void keep_contact_accelerations(System& system) {
  if (system.solver.integrator != Integrator::newmark_trapezoid) return;
  system.contact_acceleration.assign(system.disks.count() + 1, {});
  const double spin_factor = pair_terms(system).spin_factor;
  accumulate(system, system.pair_contacts, spin_factor, system.contact_acceleration);
  accumulate(system, system.wall_contacts, spin_factor, system.contact_acceleration);
}

void add_loads(System& system) {
  const double dt = system.time_step, gravity = system.gravity;
  AlignedVector<DiskMotion>& motion = system.disks.motion;
  if (system.solver.integrator == Integrator::backward_euler) {
    for (std::size_t k = 0; k < system.disks.count(); ++k)
      if (system.touched[k]) motion[k].vy -= gravity * dt;
    return;
  }
  for (std::size_t k = 0; k < system.disks.count(); ++k) motion[k].vy -= 0.5 * gravity * dt;
  if (system.solver.integrator != Integrator::newmark_trapezoid) return;
  // A filling brings forces but no accelerations: the warm start holds those forces.
  if (system.contact_acceleration.empty()) keep_contact_accelerations(system);
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    const DiskAcceleration& a = system.contact_acceleration[k];
    motion[k].vx += 0.25 * dt * a.x;
    motion[k].vy += 0.25 * dt * a.y;
    motion[k].surface_speed += 0.25 * dt * a.surface;
  }
}

}  // namespace granary::dda
