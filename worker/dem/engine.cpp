#include "worker/dem/engine.h"

#include "worker/dem/block_engine.h"
#include "worker/dem/plain_engine.h"

namespace granary::dem {

std::unique_ptr<Engine> make_engine(const EngineSetup& setup) {
  if (BlockEngine::covers(setup)) return std::make_unique<BlockEngine>(setup);
  return std::make_unique<PlainEngine>(setup);
}

}  // namespace granary::dem
