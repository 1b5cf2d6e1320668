// What a chute scene needs beyond the ranges of its fields, told before anything is queued: walls
// that leave room for a grain, an inlet that soft spheres survive, features this version has.
#pragma once

#include <cstdint>
#include <optional>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"

namespace granary {

// Precondition: defaults are filled in. The error names the field and the limit.
std::optional<Error> check_resolved_chute(const v1::Chute& chute);

// Grains that fill a hopper to about hopper_height_m; 0 with another feed.
std::uint64_t hopper_grain_count(const v1::Chute& chute);

}  // namespace granary
