// Settled grains at the start of a run: a loose grid over the floor that falls, with strongly damped
// contacts, in a closed chute under gravity normal to the floor (`initial_count`) or in a hopper whose
// gate is shut, under the gravity of the run. It is a run of its own.
#pragma once

#include <memory>
#include <vector>

#include "worker/core/column.h"
#include "worker/dem/engine.h"
#include "worker/scene/chute_plan.h"

namespace granary::scene {

std::unique_ptr<dem::Engine> make_filling(const ChutePlan& plan);
double filling_duration(const ChutePlan& plan);  // s

// The settled bed as it is stored, and the grains it stands for (at rest, in the order of their
// ids).
core::State filling_state(const dem::Engine& settled);
// Throws std::runtime_error on a state of another scene.
std::vector<dem::Grain> grains_of_filling(const core::State& filling, const ChutePlan& plan);

}  // namespace granary::scene
