#include "worker/dem/engine.h"

#include "worker/dem/block_engine.h"
#include "worker/dem/plain_engine.h"

namespace granary::dem {

std::unique_ptr<Engine> make_engine(const EngineSetup& setup) {
  const bool walls_turn = setup.motion.frame == FrameKind::inertial && setup.motion.rotates();
  if (setup.precision == Precision::full || walls_turn) return std::make_unique<PlainEngine>(setup);
  return std::make_unique<BlockEngine>(setup);
}

}  // namespace granary::dem
