// Which contact laws of a discharge can run together. Every combination is a kernel of its own
// (worker/dda/contact_effects.h), so there is a short table of them, and a scene that asks for
// another one is refused before it is queued.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"

namespace granary {

struct ContactEffectSet {
  bool particle_rotation = true;
  bool tangential_history = true;
  bool cohesion = false;
  bool rolling_friction = false;
  bool operator==(const ContactEffectSet&) const = default;
};

// What the effects of a discharge say; AUTO as decide_effects() decides it.
ContactEffectSet contact_effects(const v1::Scene& scene);

std::span<const ContactEffectSet> contact_combinations();

// "particle_rotation + tangential_history"
std::string to_string(const ContactEffectSet& effects);

// INVALID_ARGUMENT, listing the valid combinations, when the solver of a discharge has no kernel
// for its effects; also when a Newmark integrator is asked for a restitution.
Status check_contact_effects(const v1::Scene& scene);

}  // namespace granary
