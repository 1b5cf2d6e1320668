#include "proto/contract/cost_model.h"

#include <algorithm>
#include <cmath>

#include "proto/contract/chute_rules.h"

namespace granary {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Price list: CPU time of one core, 2-core Zen 4, 2026-11-22 (shipped scenes and variants of them;
// README).
constexpr double kDiskNs = 60;            // per disk step in a pack ...
constexpr double kDiskSmallStepNs = 2.7;  // ... and for each small step it is cut into
constexpr double kFlyingDiskNs = 22;
constexpr double kOpenCloseNs = 2500;
constexpr double kFlowingGrainNs = 7;
constexpr double kLyingGrainNs = 22;
constexpr double kPlainEngineFactor = 18;  // precision DOUBLE, turning walls, predicted damping
constexpr double kStartSeconds = 0.02;

constexpr double kProcessBytes = 38e6, kDiskBytes = 1500, kGrainBytes = 2700;
constexpr double kFileBytes = 270e3, kDiskFrameBytes = 49, kGrainFrameBytes = 75;
constexpr double kMemorySpread = 1.5, kDiskSpread = 1.3;  // factors either way
constexpr int kDefaultFrames = 100;

constexpr double kFillingSeconds = 0.3;        // until the disks of a bucket lie still
constexpr double kOpenCloseExtraSpread = 2.0;  // its iterations depend on the pack

struct Work {
  double steps = 0;
  double particle_steps = 0;
  double cpu_s = 0;
  double particles = 0;   // that memory is needed for
  double frame_rows = 0;  // rows of one frame, mean over the run
  void add(double phase_steps, double count, double ns) {
    steps += phase_steps;
    particle_steps += phase_steps * count;
    cpu_s += phase_steps * count * ns * 1e-9;
  }
};

// ---- discharge

double small_steps(const v1::Discharge& d, double dt) {
  const double diameter =
      0.5 * (d.particles().diameter_min_m() +
             std::max(d.particles().diameter_max_m(), d.particles().diameter_min_m()));
  const double mass = d.particles().density_kg_per_m3() * kPi / 4 * diameter * diameter;
  if (!(mass > 0)) return 1;
  return std::clamp(std::ceil(std::sqrt(d.penalty().stiffness_n_per_m() * dt * dt / mass)), 1.0,
                    200.0);
}

// Longest flight of a disk thrown from the bucket's tip, down to one radius below the axis.
double flight_s(const v1::Discharge& d, double omega) {
  const double reach = d.pulley_radius_m() - d.bucket().tip_x_m();
  const double g = std::max(d.gravity_m_per_s2(), 1e-3);
  const double speed = 0.8 * omega * reach;
  return speed / g + std::sqrt(speed * speed / (g * g) + 2 * (d.pulley_radius_m() + reach) / g);
}

Work discharge_work(const v1::Discharge& d) {
  Work work;
  const bool placed = d.filling() == v1::Discharge::EXPLICIT;
  const double count = placed ? d.discs_size() : d.particles().count();
  const bool open_close = d.solver().method() == v1::Solver::OPEN_CLOSE;
  const auto pack_ns = [&](double dt) { return kDiskNs + kDiskSmallStepNs * small_steps(d, dt); };
  const double dt = d.time_step_s(), filling_dt = d.filling_time_step_s();
  if (!placed) work.add(kFillingSeconds / filling_dt, count, pack_ns(filling_dt));
  const double reach = d.pulley_radius_m() - d.bucket().tip_x_m();
  const double omega = d.has_rademacher_ka()
                           ? std::sqrt(d.rademacher_ka() * d.gravity_m_per_s2() / reach)
                           : d.rotation_rad_per_s();
  const double end_s =
      d.has_duration_s() ? d.duration_s() : d.end_angle_deg() * kPi / 180 / std::max(omega, 1e-9);
  const double run_up_s = omega > 0 ? d.run_up_m() / (omega * d.pulley_radius_m()) : 0;
  work.add((end_s + run_up_s) / dt, count, open_close ? kOpenCloseNs : pack_ns(dt));
  if (!d.has_duration_s() && !d.no_bucket() && d.end_angle_deg() >= 180)
    work.add(std::min(5.0, flight_s(d, omega)) / dt, count, kFlyingDiskNs);
  work.particles = work.frame_rows = count;
  return work;
}

// ---- chute

double mean_mass(const v1::Chute& c) {
  double share = 0, number = 0;  // number of grains per kilogram
  for (const auto& particle : c.particles()) {
    const double mass = particle.density_kg_per_m3() * kPi / 6 * std::pow(particle.diameter_m(), 3);
    const double fraction = particle.has_mass_fraction() ? particle.mass_fraction() : 1;
    if (!(mass > 0)) continue;
    share += fraction;
    number += fraction / mass;
  }
  return number > 0 ? share / number : 1;
}

// Seconds a fed grain spends in the chute: plug slip, PHYSICS A6; a closed end keeps it.
double residence_s(const v1::Chute& c, double inlet_speed) {
  if (c.closed_end()) return 1e9;
  const double theta = c.inclination_deg() * kPi / 180;
  const double a =
      std::max(0.05 * c.gravity_m_per_s2(),
               c.gravity_m_per_s2() *
                   (std::sin(theta) - c.contact_pw().friction_coefficient() * std::cos(theta)));
  if (!(a > 0)) return inlet_speed > 0 ? c.length_m() / inlet_speed : 1e9;
  return (std::sqrt(inlet_speed * inlet_speed + 2 * a * c.length_m()) - inlet_speed) / a;
}

// Grains that lie there at the start, in the chute or in its hopper.
double settled_grains(const v1::Chute& c) {
  return c.initial_count() + static_cast<double>(hopper_grain_count(c));
}

double settling_s(const v1::Chute& c) {
  double largest = 0;
  for (const auto& particle : c.particles()) largest = std::max(largest, particle.diameter_m());
  const double spacing = 1.06 * largest;
  const bool is_hopper = c.inlet().feed() == v1::Inlet::HOPPER;
  const double length = is_hopper ? c.inlet().hopper_length_m() : c.length_m();
  const double layer = std::max(1.0, std::floor(length / spacing)) *
                       std::max(1.0, std::floor(c.width_m() / spacing));
  const double height = spacing * std::ceil(settled_grains(c) / layer);
  return 0.15 + std::sqrt(2 * height / std::max(c.gravity_m_per_s2(), 1e-3));
}

bool needs_plain_engine(const v1::Chute& c) {
  return c.precision() == v1::Chute::DOUBLE || c.damping() == v1::Chute::PREDICTED_VELOCITY ||
         (c.frame() == v1::Chute::INERTIAL && c.rotation_rpm() != 0);
}

Work chute_work(const v1::Chute& c) {
  Work work;
  const double dt = c.time_step_s(), end_s = c.duration_s();
  const double factor = needs_plain_engine(c) ? kPlainEngineFactor : 1;
  const double settled = settled_grains(c);
  const double resting = settled + c.beads_size();
  if (settled > 0) work.add(settling_s(c) / dt, settled, factor * kLyingGrainNs);
  const bool flows = c.inclination_deg() > 20 && !c.closed_end();
  const bool most_flow = flows && c.inlet().feed() != v1::Inlet::HOPPER;
  work.add(end_s / dt, resting, factor * (most_flow ? kFlowingGrainNs : kLyingGrainNs));
  work.particles = work.frame_rows = resting;
  const bool is_fed = c.inlet().feed() == v1::Inlet::LATTICE;
  if (!is_fed || !(c.inlet().mass_flow_kg_per_s() > 0)) return work;
  const double rate = c.inlet().mass_flow_kg_per_s() / mean_mass(c);
  const double density = c.particles(0).density_kg_per_m3() * 0.68;
  const double speed = c.inlet().mass_flow_kg_per_s() /
                       (density * c.width_m() * std::max(c.inlet().sluice_height_m(), 1e-6));
  const double filling_s = std::min(end_s, residence_s(c, speed));
  const double most = rate * filling_s;
  const double mean = end_s > 0 ? (0.5 * most * filling_s + most * (end_s - filling_s)) / end_s : 0;
  const double steps_before = work.steps;
  work.add(end_s / dt, mean, factor * (flows ? kFlowingGrainNs : kLyingGrainNs));
  work.steps = steps_before;  // the same steps as those of the grains that were there
  work.particles += most;
  work.frame_rows += mean;
  return work;
}

double frames_of(const v1::Scene& scene, double end_s) {
  if (scene.output().has_frame_interval_s())
    return scene.output().frame_interval_s() > 0 ? end_s / scene.output().frame_interval_s() : 0;
  return scene.output().has_frames() ? scene.output().frames() : kDefaultFrames;
}

std::string engine_key(const v1::Scene& scene) {
  if (scene.has_chute()) return needs_plain_engine(scene.chute()) ? "chute/double" : "chute";
  return scene.discharge().solver().method() == v1::Solver::OPEN_CLOSE ? "discharge/open_close"
                                                                       : "discharge";
}

Estimate around(double value, double factor) {
  return {value, value / factor, value * factor};
}

std::uint64_t particles_ever(const v1::Scene& scene) {
  if (scene.has_discharge()) {
    const v1::Discharge& d = scene.discharge();
    return d.filling() == v1::Discharge::EXPLICIT ? static_cast<std::uint64_t>(d.discs_size())
                                                  : d.particles().count();
  }
  const v1::Chute& c = scene.chute();
  double count = settled_grains(c) + c.beads_size();
  if (c.inlet().feed() == v1::Inlet::LATTICE)
    count += c.inlet().mass_flow_kg_per_s() * c.duration_s() / mean_mass(c);
  return static_cast<std::uint64_t>(count);
}

}  // namespace

CostEstimate predict_cost(const v1::Scene& resolved, const Calibration& calibration) {
  const bool is_chute = resolved.has_chute();
  const Work work = is_chute ? chute_work(resolved.chute()) : discharge_work(resolved.discharge());
  const double replicates = std::max(1u, resolved.replicates());
  CostEstimate estimate;
  estimate.engine = engine_key(resolved);
  estimate.particles = particles_ever(resolved);
  estimate.steps = replicates * work.steps;
  estimate.particle_steps = replicates * work.particle_steps;
  double half_width = calibration.log_half_width(estimate.engine);
  const SpeedRatio* ratio = calibration.find(estimate.engine);
  if (estimate.engine == "discharge/open_close" && ratio == nullptr)
    half_width += std::log(kOpenCloseExtraSpread);
  const double speed = ratio != nullptr ? std::exp(ratio->log_mean) : 1;
  const double cpu_s = speed * (kStartSeconds + replicates * work.cpu_s);
  estimate.cpu_s = around(cpu_s, std::exp(half_width));
  estimate.ns_per_particle_step =
      estimate.particle_steps > 0 ? 1e9 * cpu_s / estimate.particle_steps : 0;
  estimate.basis = ratio != nullptr
                       ? std::to_string(static_cast<int>(ratio->runs)) + " runs on this host"
                       : "shipped price list, not measured on this host";
  estimate.memory_bytes =
      around(kProcessBytes + work.particles * (is_chute ? kGrainBytes : kDiskBytes), kMemorySpread);
  const double end_s =
      is_chute ? resolved.chute().duration_s() : work.steps * resolved.discharge().time_step_s();
  estimate.disk_bytes = around(kFileBytes + frames_of(resolved, end_s) * work.frame_rows *
                                                (is_chute ? kGrainFrameBytes : kDiskFrameBytes),
                               kDiskSpread);
  return estimate;
}

namespace {

// Largest x in [low, high] for which the upper end of the interval stays within the budget.
template <typename Change>
std::optional<double> largest_within(const v1::Scene& resolved, const Calibration& calibration,
                                     double budget_s, double low, double high, Change change) {
  const auto fits = [&](double x) {
    v1::Scene scene = resolved;
    change(scene, x);
    return predict_cost(scene, calibration).cpu_s.high <= budget_s;
  };
  if (!fits(low)) return std::nullopt;
  if (fits(high)) return high;
  for (int k = 0; k < 60; ++k) {
    const double middle = std::sqrt(low * high);
    (fits(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

BudgetChoice fit_budget(const v1::Scene& resolved, const Calibration& calibration,
                        double budget_s) {
  BudgetChoice choice;
  const bool is_chute = resolved.has_chute();
  choice.fits = predict_cost(resolved, calibration).cpu_s.high <= budget_s;
  const auto largest = [&](double low, double high, auto change) {
    return largest_within(resolved, calibration, budget_s, low, high, change);
  };
  if (const auto most = largest(1, 1000, [](v1::Scene& scene, double x) {
        scene.set_replicates(static_cast<std::uint32_t>(x));
      }))
    choice.replicates = static_cast<std::uint32_t>(*most);
  const double dt = is_chute ? resolved.chute().time_step_s() : resolved.discharge().time_step_s();
  // A larger x is a smaller step; never a larger one than asked for.
  if (const auto finest = largest(1, 1e4, [&](v1::Scene& scene, double x) {
        if (is_chute) {
          scene.mutable_chute()->set_time_step_s(dt / x);
          return;
        }
        v1::Discharge& d = *scene.mutable_discharge();
        d.set_time_step_s(dt / x);
        d.set_filling_time_step_s(resolved.discharge().filling_time_step_s() / x);
      }))
    choice.time_step_s = dt / *finest;
  if (is_chute) {
    choice.duration_s =
        largest(1e-3 * resolved.chute().duration_s(), 1e3 * resolved.chute().duration_s(),
                [](v1::Scene& scene, double x) { scene.mutable_chute()->set_duration_s(x); });
    return choice;
  }
  if (resolved.discharge().filling() == v1::Discharge::EXPLICIT) return choice;
  if (const auto most = largest(1, 2e6, [](v1::Scene& scene, double x) {
        scene.mutable_discharge()->mutable_particles()->set_count(static_cast<std::uint32_t>(x));
      }))
    choice.particles = static_cast<std::uint64_t>(*most);
  return choice;
}

}  // namespace granary
