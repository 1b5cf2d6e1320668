// A discharge scene as a running simulation: filling, run-up, rotation, landing.
#pragma once

#include <memory>

#include "granary/v1/scene.pb.h"
#include "worker/core/simulation.h"

namespace granary::scene {

// `resolved` has every default filled in (proto/contract/resolve.h). `stored_filling`: what
// stored_filling() of a simulation with the same filling key gave; the run then starts with the
// rotation, bit for bit as if it had filled the bucket itself. Required for filling STORED.
// Throws std::invalid_argument when the scene is no discharge or asks for what is not built.
std::unique_ptr<core::Simulation> make_discharge(const v1::Scene& resolved,
                                                 const core::State* stored_filling = nullptr);

}  // namespace granary::scene
