// What a chute run does, in SI numbers without any protobuf: built once, never changed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"
#include "worker/dem/lattice_feed.h"
#include "worker/dem/setup.h"
#include "worker/measure/chute_observer.h"
#include "worker/scene/hopper.h"

namespace granary::scene {

struct ChutePlan {
  dem::EngineSetup engine;
  measure::ChuteGeometry geometry;
  std::optional<dem::LatticeFeedSetup> feed;
  std::optional<Hopper> hopper;   // filled with initial_count grains; its walls are in `engine`
  std::vector<dem::Grain> beads;  // placed by hand
  std::size_t initial_count = 0;  // settled grains at the start
  std::vector<double> mass_fractions;
  std::uint64_t seed = 1;
  double duration = 0;            // s
  double sample_start = 0;        // s
  double sample_interval = 0.01;  // s
};

// INVALID_ARGUMENT with field path and limit for what cannot run, UNIMPLEMENTED for what is not
// built.
Result<ChutePlan> plan_chute(const v1::Scene& resolved);

}  // namespace granary::scene
