// Leavers that nobody has taken yet, as columns of a checkpoint.
#pragma once

#include <span>
#include <vector>

#include "worker/core/column.h"
#include "worker/dem/grains.h"

namespace granary::dem {

void put_leavers(core::State& state, std::span<const Leaver> leavers);
// Throws std::runtime_error when the columns do not belong together.
std::vector<Leaver> get_leavers(const core::State& state);

}  // namespace granary::dem
