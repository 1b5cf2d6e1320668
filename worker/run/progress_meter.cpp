#include "worker/run/progress_meter.h"

#include <algorithm>
#include <cmath>

namespace granary::run {

double ProgressMeter::remaining_s(double fraction, double now_s) {
  if (start_fraction_ < 0) {
    start_fraction_ = fraction;
    start_s_ = now_s;
  }
  const double done = fraction - start_fraction_;
  return done > 0 ? (now_s - start_s_) / done * (1 - fraction) : 0;
}

v1::Progress ProgressMeter::take(const core::SimulationProgress& now, std::uint32_t replicate,
                                 double now_s, double engine_seconds,
                                 std::uint64_t particle_steps) {
  pacer_.note(now_s);
  v1::Progress message;
  const double fraction = (replicate + std::clamp(now.fraction, 0.0, 1.0)) / replicates_;
  message.set_fraction(fraction);
  message.set_phase(now.phase);
  message.set_time_s(now.time_s);
  message.set_end_time_s(now.end_time_s);
  message.set_particles(now.particles);
  message.set_contacts(now.contacts);
  message.set_steps(now.steps);
  if (particle_steps > 0)
    message.set_ns_per_particle_step(1e9 * engine_seconds / static_cast<double>(particle_steps));
  message.set_eta_s(remaining_s(fraction, now_s));
  for (const auto& [name, value] : now.current_values)
    if (std::isfinite(value)) (*message.mutable_current_values())[name] = value;
  message.set_replicate(replicate);
  message.set_replicates(replicates_);
  return message;
}

}  // namespace granary::run
