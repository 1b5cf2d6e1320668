// What a discharge scene needs beyond the ranges of its fields: a bucket the disks fit into, a
// speed or a duration, a filling that can be had.
#pragma once

#include <optional>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"

namespace granary {

// Fields as submitted, defaults not filled in. The error names the field and the limit.
std::optional<Error> check_discharge(const v1::Discharge& discharge);

}  // namespace granary
