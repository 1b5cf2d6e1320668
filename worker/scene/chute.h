// A chute scene as a running simulation: filling, feed, flow, measurements, end.
#pragma once

#include <memory>

#include "granary/v1/scene.pb.h"
#include "worker/core/simulation.h"

namespace granary::scene {

// `resolved` has every default filled in (proto/contract/resolve.h). `stored_filling`: what
// stored_filling() of a simulation with the same filling key gave; only scenes with initial_count have
// one. Throws std::invalid_argument, naming field and limit, when the scene is no chute, cannot run or
// asks for what is not built.
std::unique_ptr<core::Simulation> make_chute(const v1::Scene& resolved,
                                             const core::State* stored_filling = nullptr);

}  // namespace granary::scene
