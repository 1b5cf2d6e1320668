#include "worker/dda/step_energy.h"

#include <algorithm>
#include <cmath>

#include "worker/dda/integrators.h"

namespace granary::dda {
namespace {

using core::EnergyChannel;

struct ContactEnergy {
  double elastic = 0, integrator = 0, friction = 0, damping = 0, wall_work = 0, exchanged = 0;
  double elastic_start = 0;
  double worst_overlap = 0;
};

struct BookedContact {
  double force_n, force_t;  // N, end of the step
  double slide_n, slide_t;  // m, relative displacement of the step along n and t
  double start_share;       // weight of the force at the start in the force that does the work
};

// Normal spring: starts at overlap p0 >= 0 after closing any open gap, ends at p1 = f / K.
void book_normal(const BookedContact& c, double gap_start, double stiffness, ContactEnergy& sum) {
  const double overlap_start = std::max(-gap_start, 0.0);
  const double overlap_end = c.force_n / stiffness;
  const double stretch = overlap_end - overlap_start;
  sum.elastic_start += 0.5 * stiffness * overlap_start * overlap_start;
  sum.elastic += 0.5 * c.force_n * overlap_end;
  sum.integrator += (0.5 - c.start_share) * stiffness * stretch * stretch;
  const double force = c.force_n - c.start_share * stiffness * stretch;
  // The force acts over the whole displacement, also over the part before the gap closed, and where
  // restitution overrules the spring: that much is taken out (or given back) beside the spring.
  sum.damping -= force * (c.slide_n + stretch);
}

void book_tangential(const BookedContact& c, double stored, double stiffness, ContactEnergy& sum) {
  const double stretch = (c.force_t - stored) / stiffness;
  sum.elastic_start += 0.5 * stored * stored / stiffness;
  sum.elastic += 0.5 * c.force_t * c.force_t / stiffness;
  sum.integrator += (0.5 - c.start_share) * stiffness * stretch * stretch;
  const double force = c.force_t - c.start_share * stiffness * stretch;
  sum.friction -= force * (c.slide_t + stretch);
}

void book_list(const System& system, const ActiveContacts& contacts, const Vec2* wall_velocity,
               ContactEnergy& sum) {
  const double dt = system.time_step, stiffness = system.contact.stiffness;
  const double start_share = start_force_share(system.solver.integrator);
  const DiskMotion* motion = system.disks.motion.data();
  for (std::size_t k = 0; k < contacts.size; ++k) {
    if (contacts.slot[k] < 0) continue;
    const DiskMotion& a = motion[contacts.first[k]];
    const DiskMotion& b = motion[contacts.second[k]];
    sum.worst_overlap = std::max(sum.worst_overlap, -contacts.gap_start[k]);
    const double nx = contacts.normal_x[k], ny = contacts.normal_y[k];
    double ux = b.vx - a.vx, uy = b.vy - a.vy;
    const double force_n = contacts.impulse_n[k] / dt, force_t = contacts.impulse_t[k] / dt;
    if (wall_velocity != nullptr) {
      const Vec2 w = wall_velocity[k];
      ux += w.x, uy += w.y;
      // The wall pushes the disk with -P: work on the disk per time is -f . w.
      const double mean_n =
          force_n - start_share * (force_n + stiffness * std::min(contacts.gap_start[k], 0.0));
      const double mean_t = force_t - start_share * (force_t - contacts.stored_t[k]);
      const double work = -dt * (mean_n * (w.x * nx + w.y * ny) + mean_t * (w.y * nx - w.x * ny));
      sum.wall_work -= work;
      sum.exchanged += std::abs(work);
    }
    if (!system.contact.effects.rotation) {  // held spins drive what they rub against
      const double mean_t = force_t - start_share * (force_t - contacts.stored_t[k]);
      sum.wall_work -= dt * mean_t * (a.surface_speed + b.surface_speed);
    }
    const BookedContact booked{force_n, force_t, dt * (ux * nx + uy * ny),
                               dt * (uy * nx - ux * ny - (a.surface_speed + b.surface_speed)),
                               start_share};
    book_normal(booked, contacts.gap_start[k], stiffness, sum);
    book_tangential(booked, contacts.stored_t[k], stiffness, sum);
  }
}

double kinetic_of(const DiskMotion& v) {
  return (v.vx * v.vx + v.vy * v.vy + 0.5 * v.surface_speed * v.surface_speed) /
         (2 * v.inverse_mass);
}

double squared_forces(const CandidateList& list) {
  double sum = 0;
  for (std::size_t s = 0; s < list.size(); ++s)
    sum += list.normal_force[s] * list.normal_force[s] +
           list.tangential_force[s] * list.tangential_force[s];
  return sum;
}

void move_free(DiskPose& pose, DiskMotion& v, double dt, double gravity) {
  pose.x += dt * v.vx;
  pose.y += dt * (v.vy - 0.5 * gravity * dt);
  v.vy -= gravity * dt;
  pose.angle += dt * v.surface_speed / pose.radius;
}

void move_touched(DiskPose& pose, const DiskMotion& v, double dt) {
  pose.x += dt * v.vx;
  pose.y += dt * v.vy;
  pose.angle += dt * v.surface_speed / pose.radius;
}

// Newmark solves for the mean velocity w of the step: v+ = 2 w - v. Masses go back to M.
DiskMotion end_of_step(const DiskMotion& mean, const DiskMotion& start) {
  return {2 * mean.vx - start.vx, 2 * mean.vy - start.vy,
          2 * mean.surface_speed - start.surface_speed, start.inverse_mass};
}

}  // namespace

void open_ledger(System& system) {
  core::EnergyLedger& ledger = system.ledger;
  ledger = {};
  ledger.elastic_j = (squared_forces(system.lists.pairs) + squared_forces(system.lists.walls)) /
                     (2 * system.contact.stiffness);
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    ledger.kinetic_j += kinetic_of(system.disks.motion[k]);
    ledger.potential_j +=
        system.gravity * system.disks.pose[k].y / system.disks.motion[k].inverse_mass;
  }
  ledger.stored_at_start_j = ledger.stored_j();
  system.ledger_is_new = true;
  system.report.kinetic_energy = ledger.kinetic_j;
}

void start_elastic(System& system, double elastic_at_start) {
  core::EnergyLedger& ledger = system.ledger;
  ledger.stored_at_start_j += elastic_at_start - ledger.elastic_j;
  ledger.elastic_j = elastic_at_start;
  system.ledger_is_new = false;
}

void lower_ledger_start(System& system, double remainder) {
  system.ledger.stored_at_start_j += std::min(system.ledger.remainder_j() - remainder, 0.0);
}

void book_relinearised(System& system, double elastic_at_start) {
  core::EnergyLedger& ledger = system.ledger;
  if (system.ledger_is_new) start_elastic(system, elastic_at_start);
  const double jump = elastic_at_start - ledger.elastic_j;
  ledger[EnergyChannel::integrator] -= jump;
  ledger.throughput_j += std::abs(jump);
}

void book_contacts(System& system) {
  ContactEnergy sum;
  book_list(system, system.pair_contacts, nullptr, sum);
  book_list(system, system.wall_contacts, system.wall_velocity.data(), sum);
  system.report.worst_overlap = sum.worst_overlap;
  core::EnergyLedger& ledger = system.ledger;
  book_relinearised(system, sum.elastic_start);
  ledger.elastic_j = sum.elastic;
  ledger[EnergyChannel::integrator] += sum.integrator;
  ledger[EnergyChannel::friction] += sum.friction;
  ledger[EnergyChannel::normal_damping] += sum.damping;
  ledger[EnergyChannel::wall_work] += sum.wall_work;
  ledger.throughput_j +=
      sum.exchanged + std::abs(sum.friction) + std::abs(sum.integrator) + std::abs(sum.damping);
}

void integrate(System& system) {
  const double dt = system.time_step, gravity = system.gravity;
  const bool doubles_back = system.solver.integrator != Integrator::backward_euler;
  double kinetic = 0, landed_kinetic = 0, fall_work = 0, dissipated = 0;
  for (std::size_t k = 0; k < system.disks.count(); ++k) {
    DiskPose& pose = system.disks.pose[k];
    DiskMotion& v = system.disks.motion[k];
    const double height = pose.y;
    const DiskMotion& old = system.motion_before[k];
    if (doubles_back) {
      move_touched(pose, v, dt);
      v = end_of_step(v, old);
    } else if (system.touched[k]) {
      move_touched(pose, v, dt);
      dissipated += kinetic_of(
          {v.vx - old.vx, v.vy - old.vy, v.surface_speed - old.surface_speed, v.inverse_mass});
    } else {
      move_free(pose, v, dt, gravity);
    }
    (system.disks.landed[k] ? landed_kinetic : kinetic) += kinetic_of(v);
    fall_work += (height - pose.y) / v.inverse_mass;
  }
  core::EnergyLedger& ledger = system.ledger;
  ledger.kinetic_j = kinetic + landed_kinetic;
  ledger.potential_j -= gravity * fall_work;
  ledger[EnergyChannel::integrator] += dissipated;
  ledger.throughput_j += dissipated + std::abs(gravity * fall_work);
  system.report.kinetic_energy = kinetic;
}

}  // namespace granary::dda
