// The engine that runs.
#pragma once

#include "worker/dem/plain_engine.h"

namespace granary::dem {

using Engine = PlainEngine;

}  // namespace granary::dem
